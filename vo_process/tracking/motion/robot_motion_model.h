// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/se3.h"
#include "vo_process/tracking/motion/motion_model.h"

namespace plslam::vo {

/// Motion of the robot's body up to a frame, measured by its wheels or gyro.
struct RobotMotion {
  /// From the last measured frame, or, if the robot's poses do not reach back so far, from the previous one.
  SE3 T_fromb_b;
  bool is_from_previous = false;
  /// Pose of the rectified left camera in the body frame.
  SE3 T_b_c;

  SE3 OfCamera() const { return T_b_c.Inverse() * T_fromb_b * T_b_c; }
};

/// Predicts by the robot's own odometry instead of `MotionModel`. It only predicts: it guides the search, supports a
/// frame with few features and carries a lost camera; the pose of a frame with enough features contains none of it.
///
/// Wheels slip, and robots publish wrong motions with small covariances. A motion is used only after the robot's
/// odometry agreed with half a second of reliable measurements of the images, and if the camera can have moved like
/// that since the last frame. Its covariance comes from the constants here, not from the robot. Errors of wheels are
/// the same from frame to frame, so sigmas grow with the distance, not with its square root.
///
/// Poses of a robot arrive a little late, and live frames do not wait for them. What was extrapolated, or predicted
/// without the robot, is corrected at the next frame: its motion counts from the last measured frame.
class RobotMotionModel {
 public:
  /// Sets the robot's motion to the next frame; nullopt if there is none.
  void Expect(const std::optional<RobotMotion>& motion) { motion_ = motion; }

  /// Returns the prediction for that frame; `own` if there is no robot motion or it is not trusted.
  MotionPrediction Predict(const MotionPrediction& own, double dt_s) const;

  /// The frame was measured: T_prev_c, with the covariance of its right perturbation. `is_sure`: by its features alone.
  void Observe(const SE3& T_prev_c, const Matrix6d& covariance, double dt_s, bool is_sure);

  /// The frame was not measured, and taken to have moved by T_prev_c.
  void Miss(const SE3& T_prev_c, double dt_s);

  /// Returns the time of the last measured frame, from which the motion to the next one counts. `prev_t_ns`: time of the
  /// last frame.
  int64_t MeasuredAt(int64_t prev_t_ns) const;

  /// Whether the robot's recent motions agree with the images.
  bool agrees() const { return agrees_; }

  /// The state after a measured frame, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.agrees_, self.robot_, self.camera_, self.covariance_, self.compared_);
  }

 private:
  /// Length of the path, rotation and time of a motion, on which its covariance depends.
  struct Extent {
    double way_m = 0.0;
    double turn_rad = 0.0;
    double time_s = 0.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.way_m, self.turn_rad, self.time_s);
    }
  };

  /// Returns the motion of the camera since the last frame.
  SE3 FromPrevious() const;
  Extent After(Extent extent, double dt_s) const;
  Matrix6d Covariance(const Extent& extent) const;
  void BeginToCompare();

  std::optional<RobotMotion> motion_;
  bool agrees_ = false;
  /// Motion of the camera since the comparison began: by the robot, and as measured.
  SE3 robot_;
  SE3 camera_;
  Matrix6d covariance_ = Matrix6d::Zero();
  Extent compared_;
  /// Motion since the last measured frame, and the pose to which it led.
  Extent unseen_;
  SE3 T_seen_prev_;
};

}  // namespace plslam::vo
