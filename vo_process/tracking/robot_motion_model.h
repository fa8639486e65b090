// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/se3.h"
#include "vo_process/tracking/motion_model.h"

namespace plslam::vo {

/// How the robot's body moved from one frame to the next, by wheels or a gyro of its own.
struct RobotMotion {
  SE3 T_prevb_b;
  /// Body from the rectified left camera.
  SE3 T_b_c;

  SE3 OfCamera() const { return T_b_c.Inverse() * T_prevb_b * T_b_c; }
};

/// Predicts by the robot's own odometry in the place of `MotionModel`. A prediction only: it says where to look, helps
/// a frame that sees little and carries a lost camera, and no frame that sees enough has any of it in its pose.
///
/// Wheels slip, and robots tell nonsense with small covariances, so what they say is believed only after it has agreed
/// with what the images measured over the last half second in which they measured without doubt, and not where the
/// camera cannot have moved like that since the last frame. Its uncertainty is ours (see the constants), not the one
/// that the robot claims. Wheels err alike from frame to frame, so sigmas grow with the way, not with its root.
class RobotMotionModel {
 public:
  /// What the robot says of the motion up to the next frame; nullopt: nothing.
  void Expect(const std::optional<RobotMotion>& motion) { motion_ = motion; }

  /// The prediction for that frame, `own` where the robot says nothing or is not believed.
  MotionPrediction Predict(const MotionPrediction& own, double dt_s) const;

  /// The frame was measured: T_prev_c, and the covariance of its right perturbation. `is_sure`: by what it saw alone.
  void Observe(const SE3& T_prev_c, const Matrix6d& covariance, double dt_s, bool is_sure);

  /// The frame was not measured.
  void Miss(double dt_s);

  /// What the robot has said lately agrees with the images.
  bool agrees() const { return agrees_; }

  /// All that it goes on with after a frame that was measured, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.agrees_, self.robot_, self.camera_, self.covariance_, self.compared_);
  }

 private:
  /// Of a motion: length of its way, its turns, its time. Uncertain by these.
  struct Extent {
    double way_m = 0.0;
    double turn_rad = 0.0;
    double time_s = 0.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.way_m, self.turn_rad, self.time_s);
    }
  };

  Extent After(Extent extent, double dt_s) const;
  Matrix6d Covariance(const Extent& extent) const;
  void BeginToCompare();

  std::optional<RobotMotion> motion_;
  bool agrees_ = false;
  /// Motion of the camera since comparing began: by the robot, and as measured.
  SE3 robot_;
  SE3 camera_;
  Matrix6d covariance_ = Matrix6d::Zero();
  Extent compared_;
  /// Since the last measured frame.
  Extent unseen_;
};

}  // namespace plslam::vo
