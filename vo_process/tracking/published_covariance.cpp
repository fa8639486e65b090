// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/published_covariance.h"

namespace plslam::vo {

Matrix6d UnknownMotion() {
  Vector6d variances;
  variances << 100.0, 100.0, 100.0, 1.0, 1.0, 1.0;
  return variances.asDiagonal();
}

Matrix6d PublishedCovariance::Measure(const Tracked& tracked, const SE3& T_prev_c, const SE3& T_kf_c,
                                      bool frame_to_frame) {
  const Matrix6d& alignment = tracked.alignment.covariance;
  Matrix6d chained = ComposeCovariance(covariance_kf_c_, T_prev_c, alignment);
  if (tracked.reference == Reference::kRelocalised) chained += UnknownMotion();
  // Otherwise both ends were measured against the same landmarks, and the motion contains both errors.
  const bool exact_before = frame_to_frame || tracked.IsExactBefore();
  Matrix6d motion = exact_before ? alignment : ComposeCovariance(alignment_covariance_, T_prev_c, alignment);
  if (tracked.Jumped()) motion = chained;
  covariance_kf_c_ = exact_before ? chained : alignment;
  covariance_between_keyframes_ =
      exact_before ? chained : ComposeCovariance(alignment_covariance_kf_, T_kf_c, alignment);
  alignment_covariance_ = alignment;
  return motion;
}

void PublishedCovariance::Carry(const MotionPrediction& prediction) {
  Miss(prediction);
  alignment_covariance_ = ComposeCovariance(alignment_covariance_, prediction.T_prev_c, prediction.covariance);
}

void PublishedCovariance::Miss(const MotionPrediction& prediction) {
  covariance_kf_c_ = ComposeCovariance(covariance_kf_c_, prediction.T_prev_c, prediction.covariance);
}

void PublishedCovariance::BeginKeyframe() {
  covariance_kf_c_.setZero();
  alignment_covariance_kf_ = alignment_covariance_;
}

// After a jump, which always makes a keyframe, the relative pose to the previous keyframe has that keyframe's
// covariance, whatever was predicted meanwhile.
void PublishedCovariance::Publish(double length_sigma, const SE3& T_kf_c, OdometryResult& result) {
  const bool measured = result.state != TrackingState::kLost && !result.jumped && !result.carried;
  result.motion_covariance = uncertainty_.Of(result.T_prev_c, result.motion_covariance, measured) +
                             MotionUncertainty::OfLengths(result.T_prev_c, length_sigma);
  const SE3 T_prevkf_c = result.keyframe ? result.keyframe->T_prevkf_kf : T_kf_c;
  published_kf_c_ = result.jumped && result.keyframe
                        ? uncertainty_.Of(T_prevkf_c, result.keyframe->covariance, false)
                        : ComposeCovariance(published_kf_c_, result.T_prev_c, result.motion_covariance);
  result.covariance = ComposeCovariance(covariance_odom_kf_, T_prevkf_c, published_kf_c_);
  if (!result.keyframe) return;
  covariance_odom_kf_ = result.covariance;
  published_kf_c_.setZero();
}

}  // namespace plslam::vo
