// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/inertial/inertial_interval.h"
#include "core/inertial/sensor_diagnosis.h"
#include "vo_process/tracking/motion/inertial_motion_model.h"
#include "vo_process/tracking/motion/motion_model.h"
#include "vo_process/tracking/motion/robot_motion_model.h"

namespace plslam::vo {

/// Predicts the motion to the next frame: by the inertial sensor if it is trusted, otherwise by the robot's own
/// odometry if that agrees with the images, otherwise by constant velocity. An inertial sensor is diagnosed meanwhile.
class MotionPredictor {
 public:
  explicit MotionPredictor(const std::optional<MountedImu>& imu);

  /// Set the measurements of other sensors for the next frame, as in the models.
  void ExpectRobot(const std::optional<RobotMotion>& motion) { robot_.Expect(motion); }
  /// Samples that are stuck or saturated count as missing.
  void ExpectImu(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns);
  /// Discards them after that frame.
  void ExpectNothing();

  /// `dt_s` > 0.
  MotionPrediction Predict(double dt_s) const {
    return inertial_.Predict(robot_.Predict(velocity_.Predict(dt_s), dt_s));
  }

  /// Whether a velocity is known, so that predictions are informative without other sensors.
  bool knows_motion() const { return velocity_.knows_motion(); }
  /// Whether the prediction may replace the pose of a frame that sees nothing.
  bool CanCarry() const { return inertial_.CanCarry(); }

  MotionModel& velocity() { return velocity_; }
  RobotMotionModel& robot() { return robot_; }
  const RobotMotionModel& robot() const { return robot_; }
  const InertialMotionModel& inertial() const { return inertial_; }

  /// The first frame is at this pose.
  void StartInertial(const SE3& T_odom_c);
  /// The frame was measured, as in `InertialMotionModel::Observe`; a sensor with a harmful fault is not used from then on.
  void ObserveInertial(const SE3& T_odom_c, const Matrix6d& covariance, bool is_sure, bool jumped);
  /// As `InertialMotionModel::Drift`.
  void DriftInertial(const Matrix6d& motion_covariance) { inertial_.Drift(motion_covariance); }
  /// The frame was measured in the frame of another body, which is the world; `inertial` is that body's model.
  void ReplaceInertial(const InertialMotionModel& inertial);
  /// The frame was not measured, and taken to have moved by T_prev_c.
  void Miss(const SE3& T_prev_c, double dt_s);

  /// Faults of the inertial sensor; nullptr if there is no sensor.
  const SensorDiagnosis* diagnosis() const { return diagnosis_ ? &*diagnosis_ : nullptr; }
  /// Returns one sentence on an inertial sensor that is not used, with the number that shows why; empty for a healthy
  /// one, and before that is certain.
  std::string ImuContradiction() const;
  /// Returns one sentence on samples of an inertial sensor that is used: gaps, saturation, another rate.
  std::string ImuSampleFaults() const;

  /// Returns what the inertial sensor sensed since the last call, up to the present frame; empty if it is not used,
  /// samples are missing, or that is too long ago.
  InertialInterval TakeInterval();

  /// The state after a measured frame, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.velocity_, self.robot_, self.inertial_, self.interval_, self.interval_is_known_, self.T_odom_seen_,
      self.was_seen_);
    if (self.diagnosis_) a(*self.diagnosis_);
  }

 private:
  MotionModel velocity_;
  RobotMotionModel robot_;
  InertialMotionModel inertial_;
  std::optional<MountedImu> imu_;
  std::optional<SensorDiagnosis> diagnosis_;
  /// The interval to the next frame; empty without samples.
  int64_t from_ns_ = 0;
  int64_t to_ns_ = 0;
  /// Since the last keyframe, as far as all of it is known; else empty, and not continued before the next one.
  InertialInterval interval_;
  bool interval_is_known_ = false;
  SE3 T_odom_seen_;  ///< pose of the last frame by the images alone
  bool was_seen_ = false;
};

}  // namespace plslam::vo
