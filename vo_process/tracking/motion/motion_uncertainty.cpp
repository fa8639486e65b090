// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/motion_uncertainty.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

#include "core/map/map_graph.h"

namespace plslam::vo {
namespace {

// Number of motions between keyframes used: those of about the last hundred frames.
constexpr int kSteps = 20;
// Weight of the prior ratio 1, in motions.
constexpr double kStepsBefore = 1.0;
// Bound on the ratio of one motion: outliers occur after wrong tracking, at loop closures, or in a temporarily wrong
// map.
constexpr double kMost = 25.0;
// Lower bound, because images without noise, or landmarks with few observations, would give too small a ratio.
constexpr double kLeast = 0.05;
// Ratio above which errors count as common: in rendered worlds, whose errors are independent, adjustment changes
// motions by 0.05 to 0.35 of the tracker's variances, in real images of good cameras by 1.4 to 20.
constexpr double kIndependent = 0.5;
// Number of frames over which motions are composed before other information arrives.
constexpr double kSpan = 20.0;
// Drift (`drift_per_m` and `drift_deg_per_m` of loop_process); a rotation of one radian counts as a metre.
constexpr double kDriftPer_m = 0.005;
constexpr double kDrift_radPer_m = 0.02 * kRadPerDeg;

Matrix6d Drift(const SE3& T_prev_c) {
  const double length_m = T_prev_c.translation().norm() + T_prev_c.Log().tail<3>().norm();
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kDriftPer_m * length_m), Eigen::Vector3d::Constant(kDrift_radPer_m * length_m);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

void MotionUncertainty::Learn(const Map& map, SessionId session) {
  double sum = kStepsBefore;
  double n = kStepsBefore;
  for (auto it = map.keyframes().rbegin(); it != map.keyframes().rend() && n < kStepsBefore + kSteps; ++it) {
    const MapKeyframe& keyframe = it->second;
    const MapKeyframe* previous = keyframe.name.session == session ? map.FindKeyframe(keyframe.previous_id) : nullptr;
    if (previous == nullptr || !IsKnownStep(keyframe)) continue;
    const Eigen::LDLT<Matrix6d> claimed(keyframe.relative_covariance);
    if (claimed.info() != Eigen::Success || !claimed.isPositive()) continue;
    const SE3 T_prevkf_kf = previous->T_w_kf.Inverse() * keyframe.T_w_kf;
    const Vector6d change = (keyframe.T_prevkf_kf.Inverse() * T_prevkf_kf).Log();
    const double ratio = change.dot(claimed.solve(change)) / 6.0;
    sum += std::isfinite(ratio) ? std::min(ratio, kMost) : kMost;
    n += 1.0;
  }
  variance_scale_ = std::clamp(sum / n, kLeast, kMost);
}

double MotionUncertainty::CommonShare() const { return std::clamp(variance_scale_ - kIndependent, 0.0, 1.0); }

// A filter adds variances over `kSpan` frames, while a common error adds linearly.
Matrix6d MotionUncertainty::OfLengths(const SE3& T_prev_c, double relative_sigma) {
  const Eigen::Vector3d error = relative_sigma * (T_prev_c.R().transpose() * T_prev_c.translation());
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() = kSpan * error * error.transpose();
  return covariance;
}

Matrix6d MotionUncertainty::Of(const SE3& T_prev_c, const Matrix6d& covariance, bool measured) const {
  const double common = kSpan * CommonShare();
  const double scale = measured ? variance_scale_ + common : 1.0;
  return scale * covariance + common * Drift(T_prev_c);
}

}  // namespace plslam::vo
