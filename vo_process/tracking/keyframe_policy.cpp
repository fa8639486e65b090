#include "vo_process/tracking/keyframe_policy.h"

#include <algorithm>
#include <cmath>

#include "vo_process/tracking/entropy.h"

namespace plslam {

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

}  // namespace plslam
