// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/se3.h"

namespace plslam::robot {

/// The tracker's pose of a frame, in the frames of docs/frames.md. Covariances are those of right perturbations.
struct CameraPose {
  int64_t t_ns = 0;
  SE3 T_w_odom;
  bool anchored = true;  ///< whether T_w_odom is known
  SE3 T_odom_c;
  Matrix6d covariance = Matrix6d::Zero();
  SE3 T_prev_c;
  Matrix6d motion_covariance = Matrix6d::Zero();
  /// Time since the frame of `T_prev_c`; nullopt if it is not known.
  std::optional<double> dt_s;
};

/// The pose of the robot's body b (x forward, z up) in the conventions of ROS (REP 103, 105). The frames map and odom
/// are w and odom with the axes of the body: at the first keyframe, the body is at the origin of map and faces along x.
struct BodyPose {
  int64_t t_ns = 0;
  bool anchored = true;  ///< whether T_map_odom and T_map_b are known
  SE3 T_map_odom;
  SE3 T_odom_b;
  SE3 T_map_b;
  /// Covariance of [position; rotation about the fixed axes] in odom, as in geometry_msgs/PoseWithCovariance.
  Matrix6d covariance = Matrix6d::Zero();
  /// [linear; angular] in b, the mean since the previous frame; and its covariance; nullopt if the time step is not
  /// known.
  std::optional<Vector6d> velocity;
  Matrix6d velocity_covariance = Matrix6d::Zero();
};

/// Returns the covariance of a right perturbation [translation; rotation] of a pose with this rotation, as everywhere in
/// plslam, along the axes of the parent.
Matrix6d AlongParentAxes(const SE3& T_parent_child, const Matrix6d& covariance);

/// `T_b_c` is that of `BodyFromCamera`.
BodyPose ToBody(const SE3& T_b_c, const CameraPose& camera);

/// A point of the map w in the robot's frame map.
inline Eigen::Vector3d ToMapFrame(const SE3& T_b_c, const Eigen::Vector3d& p_w) { return T_b_c * p_w; }

}  // namespace plslam::robot
