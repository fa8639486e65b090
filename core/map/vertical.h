// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "core/map/map.h"

namespace plslam {

/// The up direction in the map frame, which has the axes of the first keyframe and is tilted like that camera.
struct Vertical {
  Eigen::Vector3d up_w = -Eigen::Vector3d::UnitY();  ///< unit length
  /// Lines of the map that agree, within 3 degrees of `up_w`; 0: `up_w` comes from the cameras (MeanUpOfCameras).
  int64_t n_lines = 0;
};

/// Returns the mean up direction (-y of c) of the keyframes; -y of w without keyframes, or if they cancel each other.
Eigen::Vector3d MeanUpOfCameras(const Map& map);

/// Returns the common direction of the lines within 45 degrees of `about_w`: corners of buildings, door frames, posts.
/// Each line votes with its precision (endpoint covariances over its length); the direction with most votes is refined
/// by a mean with Tukey's weights, which slanted lines do not bias. Returns nullopt if fewer than 8 lines, or less than
/// a fifth of the votes, agree.
std::optional<Vertical> VerticalFromLines(const Map& map, const Eigen::Vector3d& about_w);

/// Returns the direction of the lines near the mean up of the cameras if there is one, else that mean.
Vertical VerticalOf(const Map& map);

/// Returns the shortest rotation from w to the levelled frame, in which up is -y (x right, y down, z forward, as in w).
Eigen::Quaterniond LevelRotation(const Eigen::Vector3d& up_w);

}  // namespace plslam
