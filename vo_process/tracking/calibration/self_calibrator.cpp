// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/self_calibrator.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

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

std::vector<double> PointDisparities(const StereoFeatures& features) {
  std::vector<double> disparities;
  disparities.reserve(features.points.size());
  for (const StereoPoint& point : features.points) disparities.push_back(point.disparity_px);
  return disparities;
}

}  // namespace

SelfCalibrator::SelfCalibrator(const StereoCamera& camera, const VoOptions& options, const RollingShutter& shutter)
    : camera_(camera),
      options_(options),
      noise_scale_(options.landmarks.max_point_scale),
      disparities_(camera, options.disparity_calibration),
      rows_(camera, options.row_calibration),
      corner_budget_(options.features.orb.max_points),
      lenses_(camera),
      sync_(camera),
      timing_(camera, shutter),
      shutter_(shutter),
      states_readout_(!shutter.is_global()) {}

void SelfCalibrator::Begin(const SelfCalibration& learned) {
  if (learned.rows) rows_.Begin(*learned.rows);
  if (learned.disparities) disparities_.Begin(*learned.disparities);
}

double SelfCalibrator::contradicting_readout_s() const {
  const auto shown = timing_.EstimateOf(TimingCheck::kReadoutOfTurning);
  if (!states_readout_ || !shown) return 0.0;
  const double stated_s = shutter_.readout_s();
  const bool is_large =
      std::abs(shown->value - stated_s) > std::max(kContradicting_s, kContradictingShare * stated_s);
  return is_large && shown->DiffersFrom(stated_s, kContradictingSigmas) ? shown->value : 0.0;
}

void SelfCalibrator::PredictSkew(const SE3& T_prev_c, double dt_s) {
  skew_ = sync_.late_s() == 0.0 ? PairSkew() : sync_.SkewOf(T_prev_c, dt_s);
}

bool SelfCalibrator::Accepts(StereoFeatures& followed) {
  if (LearnRows(followed)) return false;
  lenses_.RemoveFromFollowed(followed);
  return true;
}

StereoFeatures SelfCalibrator::SeePair(StereoFrontEnd& front_end, StageTimer& timer) {
  const bool knew_dirt = lenses_.HasDirt();
  front_end.SetDirt(lenses_.Cells());
  const bool looks = rows_.needs_look();
  if (looks) timer.Time("rows", [&] { LearnRows(front_end.LookForRows(skew_)); });
  const auto see = [&] { return front_end.Detect(timer, rows(), corner_budget_.max_points() + lenses_.n_removed()); };
  StereoFeatures features = see();
  if (!looks && LearnRows(features)) features = see();
  lenses_.Observe(features, front_end.right_corners(), front_end.left_mask(), front_end.right_mask());
  if (!knew_dirt && lenses_.HasDirt()) {
    lenses_.RemoveFrom(features);
    front_end.SetDirt(lenses_.Cells());
    features = see();
  }
  lenses_.RemoveFrom(features);
  return features;
}

/// Returns whether `rows` has become zero or nonzero; disparities before and after are then inconsistent.
bool SelfCalibrator::LearnRows(const StereoFeatures& features) {
  const bool changed = rows_.Observe(features, skew_);
  if (changed) disparities_ = DisparityCalibration(camera_, options_.disparity_calibration);
  return changed;
}

TrackedFrame SelfCalibrator::Prepare(StereoFeatures features) const {
  AddLineModelError(options_.landmarks.line_model_sigma_px, features);
  std::vector<double> raw_disparities_px = PointDisparities(features);
  noise_scale_.Apply(features);
  disparities_.Correct(features);
  TrackedFrame frame(std::move(features));
  frame.raw_disparities_px = std::move(raw_disparities_px);
  frame.point_sigma_scale = noise_scale_.scale();
  return frame;
}

void SelfCalibrator::MoveToStamp(const Vector6d& velocity, TrackedFrame& frame) const {
  if (shutter_.is_global()) return;
  if (!frame.rolling) frame.rolling.emplace(shutter_, frame.features);
  frame.MoveToStamp(velocity);
}

bool SelfCalibrator::LearnTiming(const SE3& T_odom_c, const SE3& T_prev_c, double dt_s, TrackedFrame& frame) {
  const Vector6d mean = T_prev_c.Log() / dt_s;
  const Vector6d velocity = velocity_.After(mean);
  velocity_.Observe(mean);
  TimingCheck::Parameters applied = TimingCheck::Parameters::Zero();
  applied(TimingCheck::kLate) = sync_.late_s();
  applied(TimingCheck::kReadoutOfTurning) = applied(TimingCheck::kReadoutOfTranslation) = shutter_.readout_s();
  if (const auto learned = disparities_.learned())
    applied.segment<3>(TimingCheck::kOffset) = learned->coefficients_px;
  timing_.Observe(frame, T_odom_c, velocity, applied, dt_s);
  return !states_readout_ && UseFoundReadout(velocity, frame);
}

/// Returns whether the readout is first applied: disparities so far were compared with displaced motions.
bool SelfCalibrator::UseFoundReadout(const Vector6d& velocity, TrackedFrame& frame) {
  const auto found = timing_.EstimateOf(TimingCheck::kReadoutOfTurning);
  if (!found) return false;
  if (!shutter_.is_global()) {
    shutter_.SetReadout(found->value > 0.5 * kMinReadout_s ? found->value : 0.0);
    return false;
  }
  const auto delay = timing_.EstimateOf(TimingCheck::kLate);
  const bool delay_is_pending = sync_.late_s() == 0.0 && delay->DiffersFrom(0.0, kPendingDelaySigmas);
  if (timing_.n_pairs() < kMinReadoutPairs || delay_is_pending) return false;
  if (!(found->value > kMinReadout_s) || !found->DiffersFrom(0.0, kMinReadoutSigmas)) return false;
  shutter_.SetReadout(found->value);
  MoveToStamp(velocity, frame);
  timing_.Interrupt();
  disparities_ = DisparityCalibration(camera_, options_.disparity_calibration);
  return true;
}

bool SelfCalibrator::LearnDisparities(const SE3& T_odom_c, TrackedFrame& frame) {
  const auto before = disparities_.learned();
  if (!disparities_.Observe(T_odom_c, frame, frame.raw_disparities_px)) return false;
  const auto change_px = [&](double u_px) {
    return before ? -DisparityErrorTerms(camera_, u_px).dot(before->coefficients_px) : disparities_.Offset_px(u_px);
  };
  CorrectDisparities(frame.features, [&](const Eigen::Vector2d& left_px, double) { return change_px(left_px.x()); });
  return true;
}

// Discards the calibrations that were estimated with a wrong time offset.
bool SelfCalibrator::LearnDelay(const SE3& T_prev_c, double dt_s, TrackedFrame& frame) {
  if (!sync_.Observe(frame, dt_s, timing_.EstimateOf(TimingCheck::kLate))) return false;
  rows_ = RowCalibration(camera_, options_.row_calibration);
  disparities_ = DisparityCalibration(camera_, options_.disparity_calibration);
  RemoveSkew(sync_.SkewOf(T_prev_c, dt_s), frame.features);
  return true;
}

void SelfCalibrator::InterruptTiming() {
  velocity_.Interrupt();
  timing_.Interrupt();
}

void SelfCalibrator::Interrupt() {
  InterruptTiming();
  disparities_.Interrupt();
  sync_.Interrupt();
}

}  // namespace plslam::vo
