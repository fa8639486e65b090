// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/geometry/se3.h"
#include "core/ids/ids.h"
#include "core/map/map.h"
#include "vo_process/tracking/motion/motion_model.h"
#include "vo_process/tracking/motion/motion_uncertainty.h"
#include "vo_process/tracking/odometry_result.h"
#include "vo_process/tracking/recovery.h"

namespace plslam::vo {

/// Covariance of the motion of a camera that saw nothing meanwhile: sigmas of 10 m and one radian.
Matrix6d UnknownMotion();

/// Covariances of the tracker's motions (of their right perturbations): those measured, which the tracker uses itself,
/// and those published, which include errors that frames have in common (`MotionUncertainty`).
///
/// A pose is measured against landmarks. If both ends of a motion were measured against the same ones, the motion
/// contains both errors; if the landmarks were created at its beginning, only that of its end.
class PublishedCovariance {
 public:
  /// Compares the covariances with the map of a session.
  void Learn(const Map& map, SessionId session) { uncertainty_.Learn(map, session); }

  /// Adds a tracked frame. `T_kf_c` is the motion since the last keyframe; `frame_to_frame`: landmarks are created
  /// again in each frame. Returns the covariance of the motion since the previous frame.
  Matrix6d Measure(const Tracked& tracked, const SE3& T_prev_c, const SE3& T_kf_c, bool frame_to_frame);
  /// Adds a frame whose pose is carried, or lost.
  void Carry(const MotionPrediction& prediction);
  void Miss(const MotionPrediction& prediction);

  /// The frame becomes a keyframe.
  void BeginKeyframe();

  /// Measured: of the motion since the last keyframe, of the pose given the landmarks, and of the motion between the
  /// last two keyframes if the frame becomes one.
  const Matrix6d& since_keyframe() const { return covariance_kf_c_; }
  const Matrix6d& alignment() const { return alignment_covariance_; }
  const Matrix6d& between_keyframes() const { return covariance_between_keyframes_; }

  /// Replaces the measured covariance of a frame's motion by the published one, and sets that of its pose.
  /// `length_sigma`: relative sigma that lengths have in common.
  void Publish(double length_sigma, const SE3& T_kf_c, OdometryResult& result);

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.uncertainty_, self.alignment_covariance_, self.covariance_odom_kf_, self.published_kf_c_,
      self.covariance_kf_c_, self.alignment_covariance_kf_, self.covariance_between_keyframes_);
  }

 private:
  MotionUncertainty uncertainty_;
  /// Covariance of the camera's pose given the landmarks, at the previous frame and at the last keyframe.
  Matrix6d alignment_covariance_ = Matrix6d::Zero();
  Matrix6d alignment_covariance_kf_ = Matrix6d::Zero();
  /// Covariances of the motion since the last keyframe, given the landmarks, and of the motion between two keyframes:
  /// both its ends were measured against the landmarks, so it is less certain.
  Matrix6d covariance_kf_c_ = Matrix6d::Zero();
  Matrix6d covariance_between_keyframes_ = Matrix6d::Zero();
  /// Published covariances of the keyframe's pose and of the motion since.
  Matrix6d covariance_odom_kf_ = Matrix6d::Zero();
  Matrix6d published_kf_c_ = Matrix6d::Zero();
};

}  // namespace plslam::vo
