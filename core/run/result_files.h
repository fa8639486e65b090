// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace plslam {

/// Files of a run in its folder, except for pictures and logs.
inline constexpr std::array<const char*, 25> kResultFiles{
    "summary.json", "report.html", "trajectory.tum", "trajectory.kitti", "trajectory.euroc", "trajectory_live.tum",
    "keyframes.tum", "keyframes.kitti", "keyframes.euroc", "groundtruth.tum", "covariance.txt",
    "motion_covariance.txt", "poses.csv", "bodies.csv", "map.ply",
    // of dense_process
    "cloud.ply", "mesh.ply", "map.bt", "map.ot", "map.pgm", "map.yaml", "map_distance.png", "map_height.png",
    "path.csv", "frames.json"};

}  // namespace plslam
