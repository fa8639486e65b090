// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/keyframe_policy.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/symmetric.h"

namespace plslam::vo {
namespace {

constexpr double kReference = 30.0;
// Above this, the quotient of entropies is ill conditioned.
constexpr double kClearlyNegative = -5.0;

}  // namespace

std::optional<double> MotionEntropy(const Matrix6d& covariance) {
  if (!covariance.allFinite()) return std::nullopt;
  // Scales to unit diagonal first, so that metres and radians of very different size do not cancel.
  const Vector6d diagonal = covariance.diagonal();
  if (!(diagonal.minCoeff() > 0.0)) return std::nullopt;
  const Vector6d scale = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix6d correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Vector6d eigenvalues = EigenOf<6>(correlation).values;
  if (!(eigenvalues.minCoeff() > 1e-14)) return std::nullopt;
  const double log_determinant = eigenvalues.array().log().sum() + diagonal.array().log().sum();
  return 3.0 * (1.0 + std::log(2.0 * std::numbers::pi)) + 0.5 * log_determinant;
}

std::optional<double> EntropyRatio(const Matrix6d& covariance_first, const Matrix6d& covariance_now) {
  const std::optional<double> first = MotionEntropy(covariance_first);
  const std::optional<double> now = MotionEntropy(covariance_now);
  if (!first || !now) return std::nullopt;
  if (*first < kClearlyNegative) return *now / *first;
  return 1.0 - (*now - *first) / kReference;
}

KeyframeDecision KeyframePolicy::Decide(const KeyframeCandidate& candidate) {
  ++frames_;
  KeyframeDecision decision;
  if (frames_ == 1) {
    first_covariance_ = candidate.covariance;
    first_tracked_ = candidate.tracked_from_keyframe;
  }
  const std::optional<double> entropy_ratio = EntropyRatio(first_covariance_, candidate.covariance);
  decision.entropy_ratio = entropy_ratio.value_or(0.0);

  const double depth_m = std::max(candidate.median_depth_m, 1e-3);
  const double baseline_ratio = candidate.T_kf_c.translation().norm() / depth_m;
  const double rotation_deg = candidate.T_kf_c.Log().tail<3>().norm() * 180.0 / M_PI;
  const bool moved = baseline_ratio > options_.min_baseline_ratio || rotation_deg > options_.min_rotation_deg;
  if (!moved) return decision;

  if (entropy_ratio && *entropy_ratio < options_.entropy_ratio) {
    decision.reason = KeyframeReason::kEntropy;
  } else if (candidate.tracked_from_keyframe < options_.min_tracked_ratio * first_tracked_) {
    decision.reason = KeyframeReason::kTracked;
  } else if (candidate.known_share >= options_.known_share) {
    return decision;
  } else if (baseline_ratio > options_.max_baseline_ratio) {
    decision.reason = KeyframeReason::kBaseline;
  } else if (rotation_deg > options_.max_rotation_deg) {
    decision.reason = KeyframeReason::kRotation;
  } else if (frames_ >= options_.max_frames) {
    decision.reason = KeyframeReason::kAge;
  }
  return decision;
}

void KeyframePolicy::Restart() { frames_ = 0; }

}  // namespace plslam::vo
