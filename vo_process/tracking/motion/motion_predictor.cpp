// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/motion_predictor.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace plslam::vo {
namespace {

/// Joins the texts of harmful, or of harmless, findings.
std::string Joined(const SensorDiagnosis& diagnosis, bool harmful) {
  std::string text;
  for (const SensorFinding& finding : diagnosis.findings()) {
    if (finding.is_harmful == harmful) text += (text.empty() ? "" : "; ") + finding.text;
  }
  return text;
}

}  // namespace

MotionPredictor::MotionPredictor(const std::optional<MountedImu>& imu) : inertial_(imu), imu_(imu) {
  if (imu) diagnosis_.emplace(imu->calibration, imu->T_imu_c);
}

void MotionPredictor::ExpectImu(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns) {
  from_ns_ = to_ns_ = 0;
  if (!diagnosis_ || from_ns >= to_ns) return inertial_.Expect({}, from_ns, to_ns);
  const int64_t offset_ns = imu_->calibration.offset_ns();
  from_ns_ = from_ns - offset_ns;
  to_ns_ = to_ns - offset_ns;
  const bool are_measured = diagnosis_->Add(samples, to_ns_);
  inertial_.Expect(samples, from_ns, to_ns, are_measured);
  interval_is_known_ = interval_is_known_ && are_measured && interval_.to_ns == from_ns_ &&
                       interval_.LengthUntil(to_ns_) <= InertialInterval::kLongest_ns;
  if (interval_is_known_) {
    // Samples of earlier frames may be late.
    const int64_t newest_ns = interval_.samples.empty() ? from_ns_ : interval_.samples.back().t_ns;
    interval_.Append(SamplesOfMotion(samples, std::min(from_ns_, newest_ns), to_ns_), to_ns_);
  } else {
    interval_ = {};
  }
}

InertialInterval MotionPredictor::TakeInterval() {
  InertialInterval taken = std::exchange(interval_, {});
  if (!imu_) return {};
  interval_.from_ns = interval_.to_ns = to_ns_;
  if (!std::exchange(interval_is_known_, to_ns_ != 0) || taken.empty() || !inertial_.IsHealthy()) return {};
  taken.T_c_imu = imu_->T_imu_c.Inverse();
  taken.noise = imu_->calibration.noise;
  taken.bias = inertial_.filter().Bias();
  return taken.Motion() ? taken : InertialInterval();
}

void MotionPredictor::ExpectNothing() {
  ExpectRobot(std::nullopt);
  inertial_.ExpectNothing();
  from_ns_ = to_ns_ = 0;
}

void MotionPredictor::StartInertial(const SE3& T_odom_c) {
  inertial_.Start(T_odom_c);
  T_odom_seen_ = T_odom_c;
  was_seen_ = true;
}

void MotionPredictor::ObserveInertial(const SE3& T_odom_c, const Matrix6d& covariance, bool is_sure, bool jumped) {
  if (diagnosis_) {
    const SE3 T_odom_previous = std::exchange(T_odom_seen_, T_odom_c);
    const bool follows = std::exchange(was_seen_, is_sure) && is_sure && !jumped;
    if (follows) diagnosis_->Add(from_ns_, to_ns_, T_odom_previous.Inverse() * T_odom_c, 2.0 * covariance);
  }
  inertial_.Observe(T_odom_c, covariance, is_sure, jumped);
  if (diagnosis_) inertial_.SetFaulty(diagnosis_->IsHarmful());
}

void MotionPredictor::ReplaceInertial(const InertialMotionModel& inertial) {
  inertial_ = inertial;
  was_seen_ = false;
}

void MotionPredictor::Miss(const SE3& T_prev_c, double dt_s) {
  velocity_.Slow(dt_s);
  robot_.Miss(T_prev_c, dt_s);
  inertial_.Miss();
  was_seen_ = false;
}

std::string MotionPredictor::ImuContradiction() const {
  if (!diagnosis_) return {};
  const std::string complaint = inertial_.Complaint();
  if (!diagnosis_->HasConverged()) return {};
  const std::string harmful = Joined(*diagnosis_, true);
  if (!harmful.empty()) {
    return fmt::format(
        "the inertial sensor contradicts the images, so it is not used: {} (normalised innovation {:.1f}, 1 is "
        "healthy)",
        harmful, inertial_.normalised_innovation());
  }
  const std::string others = Joined(*diagnosis_, false);
  return complaint.empty() || others.empty() ? complaint : complaint + "; " + others;
}

std::string MotionPredictor::ImuSampleFaults() const {
  if (!diagnosis_ || !diagnosis_->HasConverged()) return {};
  const std::string faults = Joined(*diagnosis_, false);
  return faults.empty() ? faults : "the inertial sensor is used with care: " + faults;
}

}  // namespace plslam::vo
