// SPDX-License-Identifier: BSD-3-Clause
// Odometry's self-calibration, and its rolling shutter.
#include <algorithm>
#include <cmath>
#include <utility>

#include "vo_process/stereo/row_field.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

// A readout that is not stated is applied above this time, and so many standard deviations.
constexpr double kMinReadout_s = 4e-3;
constexpr double kMinReadoutSigmas = 20.0;
// It waits for so many pairs of frames, and for a delay of so many sigmas to be applied: few pairs confuse the two.
constexpr int64_t kMinReadoutPairs = 5;
constexpr double kPendingDelaySigmas = 4.0;
// A stated readout is contradicted by so many standard deviations, and so much.
constexpr double kContradictingSigmas = 3.0;
constexpr double kContradicting_s = 1e-3;
constexpr double kContradictingShare = 0.05;

}  // namespace

// All measurements so far contain the offset, or lack it, when it is first applied or no longer applied.
void Odometry::CalibrateDisparities(TrackedFrame& frame) {
  const auto before = calibration_.learned();
  if (!calibration_.Observe(T_odom_c_, frame, frame.raw_disparities_px)) return;
  const auto change_px = [&](double u_px) {
    return before ? -DisparityErrorTerms(camera_, u_px).dot(before->coefficients_px) : calibration_.Offset_px(u_px);
  };
  CorrectDisparities(frame.features, [&](const Eigen::Vector2d& left_px, double) { return change_px(left_px.x()); });
  landmarks_.Initialise(T_odom_c_, frame);
  keyframe_measurements_ = KeyframeMeasurements(camera_);
  bodies_.Forget();
}

// Discards the calibrations and landmarks that were estimated with a wrong time offset.
void Odometry::CheckSync(TrackedFrame& frame, const SE3& T_prev_c, double dt_s) {
  if (!sync_check_.Observe(frame, dt_s, timing_check_.EstimateOf(TimingCheck::kLate))) return;
  row_calibration_ = RowCalibration(camera_, options_.row_calibration);
  calibration_ = DisparityCalibration(camera_, options_.disparity_calibration);
  RemoveSkew(sync_check_.SkewOf(T_prev_c, dt_s), frame.features);
  bodies_.Forget();
  landmarks_.Initialise(T_odom_c_, frame);
}

/// Learns the times of rows and images from motions over several frames, and the velocity for the next frame.
void Odometry::CheckTiming(TrackedFrame& frame, const OdometryResult& result, double dt_s) {
  if (result.jumped || result.state == TrackingState::kRecovered) {
    has_last_velocity_ = false;
    timing_check_.Interrupt();
    return;
  }
  const Vector6d mean = result.T_prev_c.Log() / dt_s;
  const Vector6d velocity = has_last_velocity_ ? Vector6d(mean + 0.5 * (mean - last_velocity_)) : mean;
  has_last_velocity_ = true;
  last_velocity_ = mean;
  TimingCheck::Parameters applied = TimingCheck::Parameters::Zero();
  applied(TimingCheck::kLate) = sync_check_.late_s();
  applied(TimingCheck::kReadoutOfTurning) = applied(TimingCheck::kReadoutOfTranslation) = shutter_.readout_s();
  if (const auto learned = calibration_.learned())
    applied.segment<3>(TimingCheck::kOffset) = learned->coefficients_px;
  timing_check_.Observe(frame, T_odom_c_, velocity, applied, dt_s);
  if (!states_readout_) UseFoundReadout(velocity, frame);
}

// Landmarks are created again when the readout is first applied: they are displaced, and so are the disparities that
// were compared with their motions.
void Odometry::UseFoundReadout(const Vector6d& velocity, TrackedFrame& frame) {
  const auto found = timing_check_.EstimateOf(TimingCheck::kReadoutOfTurning);
  if (!found) return;
  if (!shutter_.is_global()) return shutter_.SetReadout(found->value > 0.5 * kMinReadout_s ? found->value : 0.0);
  const auto delay = timing_check_.EstimateOf(TimingCheck::kLate);
  const bool delay_is_pending = sync_check_.late_s() == 0.0 && delay->DiffersFrom(0.0, kPendingDelaySigmas);
  if (timing_check_.n_pairs() < kMinReadoutPairs || delay_is_pending) return;
  if (!(found->value > kMinReadout_s) || !found->DiffersFrom(0.0, kMinReadoutSigmas)) return;
  shutter_.SetReadout(found->value);
  rolling_.emplace(shutter_, frame.features);
  MoveToStamp(velocity, frame);
  timing_check_.Interrupt();
  calibration_ = DisparityCalibration(camera_, options_.disparity_calibration);
  keyframe_measurements_ = KeyframeMeasurements(camera_);
  bodies_.Forget();
  landmarks_.Initialise(T_odom_c_, frame);
}

double Odometry::contradicting_readout_s() const {
  const auto shown = timing_check_.EstimateOf(TimingCheck::kReadoutOfTurning);
  if (!states_readout_ || !shown) return 0.0;
  const double stated_s = shutter_.readout_s();
  const bool is_large =
      std::abs(shown->value - stated_s) > std::max(kContradicting_s, kContradictingShare * stated_s);
  return is_large && shown->DiffersFrom(stated_s, kContradictingSigmas) ? shown->value : 0.0;
}

/// Moves the features to where a camera of this velocity observes them at the time of the stamp.
void Odometry::MoveToStamp(const Vector6d& velocity, TrackedFrame& frame) {
  const StereoFeatures before = std::move(frame.features);
  frame.features = rolling_->MovedBy(velocity);
  for (size_t i = 0; i < before.points.size(); ++i) {
    frame.raw_disparities_px[i] += frame.features.points[i].disparity_px - before.points[i].disparity_px;
  }
  frame.point_grid = PointGrid(frame.features.points);
}

/// Estimates pose and velocity in turn: each needs the other. The velocity at the stamp is the mean since the previous
/// frame, continued with half of its change.
void Odometry::EstimateVelocity(double dt_s, Tracked& tracked, TrackedFrame& frame) {
  constexpr int kPasses = 2;
  const auto mean_velocity = [&] {
    return Vector6d((T_odom_c_.Inverse() * tracked.alignment.T_odom_c).Log() / dt_s);
  };
  if (tracked.reference != Reference::kCurrent) return;
  Alignment& alignment = tracked.alignment;
  aligner_.SetDisparities(landmarks_, alignment, *rolling_);
  for (int pass = 0; pass < kPasses && !alignment.weak; ++pass) {
    const Vector6d mean = mean_velocity();
    const Vector6d change = has_last_velocity_ ? Vector6d(mean - last_velocity_) : Vector6d::Zero();
    MoveToStamp(mean + 0.5 * change, frame);
    const auto better = aligner_.Estimate(landmarks_, frame, alignment.matches, alignment.T_odom_c, std::nullopt);
    if (!better) break;
    alignment.T_odom_c = better->T_odom_c;
    alignment.covariance = better->covariance;
  }
}

/// The first measured motion shows by how much the landmarks created before it were displaced.
void Odometry::UseFirstVelocity(const SE3& T_prev_c, double dt_s, TrackedFrame& frame) {
  MoveToStamp(T_prev_c.Log() / dt_s, frame);
  landmarks_.Initialise(T_odom_c_, frame);
}

}  // namespace plslam::vo
