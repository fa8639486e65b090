// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/level_frame.h"

#include "core/map/vertical.h"

namespace plslam {
namespace {

/// `level` is the rotation from w to the levelled frame (LevelRotation).
SE3 FromLevelled(const Eigen::Quaterniond& level) {
  // From x right, y down, z forward to x forward, y left, z up.
  const Eigen::Quaterniond turn(0.5, -0.5, 0.5, -0.5);
  return {turn * level, Eigen::Vector3d::Zero()};
}

}  // namespace

SE3 LevelFromMap(const Map& map) { return FromLevelled(LevelRotation(VerticalOf(map).up_w)); }

SE3 LevelFromCamera() { return FromLevelled(Eigen::Quaterniond::Identity()); }

}  // namespace plslam
