// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace plslam {

/// Files of a run in its folder, except for pictures and logs.
inline constexpr std::array<const char*, 15> kResultFiles{
    "summary.json",        "report.html",           "trajectory.tum",  "trajectory.kitti", "trajectory.euroc",
    "trajectory_live.tum", "keyframes.tum",         "keyframes.kitti", "keyframes.euroc",  "groundtruth.tum",
    "covariance.txt",      "motion_covariance.txt", "poses.csv",       "bodies.csv",       "map.ply"};

}  // namespace plslam
