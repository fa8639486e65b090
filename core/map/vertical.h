// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "core/map/map.h"

namespace plslam {

/// Which way is up in w, which has the axes of the first keyframe and so leans as that camera leaned.
struct Vertical {
  Eigen::Vector3d up_w = -Eigen::Vector3d::UnitY();  ///< unit length
  /// Lines of the map that say so, within 3 degrees of `up_w`; 0: the cameras say so (MeanUpOfCameras).
  int64_t n_lines = 0;
};

/// Mean of up (-y of c) over the keyframes; -y of w without keyframes, and where they cancel each other.
Eigen::Vector3d MeanUpOfCameras(const Map& map);

/// The direction that the lines within 45 degrees of `about_w` share: corners of buildings, frames of doors, posts.
/// Each line votes with its precision (covariances of the endpoints over its length); the direction with most votes
/// is refined by a mean with Tukey's weights, so that slanted lines do not bend it. nullopt where fewer than 8 lines
/// agree, or less than a fifth of the votes: then nothing there stands upright.
std::optional<Vertical> VerticalFromLines(const Map& map, const Eigen::Vector3d& about_w);

/// From the lines near the mean up of the cameras, where they share a direction, else that mean itself.
Vertical VerticalOf(const Map& map);

/// The shortest rotation from w to the levelled frame, in which up is -y (x right, y down, z forward, as in w).
Eigen::Quaterniond LevelRotation(const Eigen::Vector3d& up_w);

}  // namespace plslam
