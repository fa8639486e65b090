// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "vo_process/tracking/motion/inertial_motion_model.h"
#include "vo_process/tracking/motion/motion_model.h"
#include "vo_process/tracking/motion/robot_motion_model.h"

namespace plslam::vo {

/// Predicts the motion to the next frame: by the inertial sensor if it is trusted, otherwise by the robot's own
/// odometry if that agrees with the images, otherwise by constant velocity.
class MotionPredictor {
 public:
  explicit MotionPredictor(const std::optional<MountedImu>& imu) : inertial_(imu) {}

  /// Set the measurements of other sensors for the next frame, as in the models.
  void ExpectRobot(const std::optional<RobotMotion>& motion) { robot_.Expect(motion); }
  void ExpectImu(std::span<const ImuSample> samples, int64_t from_ns, int64_t to_ns) {
    inertial_.Expect(samples, from_ns, to_ns);
  }
  /// Discards them after that frame.
  void ExpectNothing() {
    ExpectRobot(std::nullopt);
    ExpectImu({}, 0, 0);
  }

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
  InertialMotionModel& inertial() { return inertial_; }
  const InertialMotionModel& inertial() const { return inertial_; }

  /// The frame was not measured.
  void Miss(double dt_s) {
    velocity_.Slow(dt_s);
    robot_.Miss(dt_s);
    inertial_.Miss();
  }

  /// The state after a measured frame, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.velocity_, self.robot_, self.inertial_);
  }

 private:
  MotionModel velocity_;
  RobotMotionModel robot_;
  InertialMotionModel inertial_;
};

}  // namespace plslam::vo
