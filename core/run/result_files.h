// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace plslam {

/// Names of the files of a run in its folder (docs/viewer.md, docs/planning.md): the only place that spells them.
namespace result_file {

/// A trajectory in three formats.
struct Trajectories {
  const char* tum;
  const char* kitti;
  const char* euroc;
};

inline constexpr const char* kSummary = "summary.json";
inline constexpr const char* kReport = "report.html";
inline constexpr Trajectories kTrajectory{"trajectory.tum", "trajectory.kitti", "trajectory.euroc"};
inline constexpr const char* kLiveTrajectory = "trajectory_live.tum";
inline constexpr Trajectories kKeyframes{"keyframes.tum", "keyframes.kitti", "keyframes.euroc"};
inline constexpr const char* kTruth = "groundtruth.tum";
inline constexpr const char* kCovariances = "covariance.txt";
inline constexpr const char* kMotionCovariances = "motion_covariance.txt";
inline constexpr const char* kFrameTable = "poses.csv";
inline constexpr const char* kBodies = "bodies.csv";
inline constexpr const char* kLandmarks = "map.ply";

// The files of dense_process.
inline constexpr const char* kCloud = "cloud.ply";
inline constexpr const char* kMesh = "mesh.ply";
inline constexpr const char* kOccupiedVoxels = "map.bt";
inline constexpr const char* kVoxels = "map.ot";
inline constexpr const char* kGrid = "map.pgm";
inline constexpr const char* kGridMetadata = "map.yaml";
inline constexpr const char* kDistances = "map_distance.png";
inline constexpr const char* kHeights = "map_height.png";
inline constexpr const char* kPath = "path.csv";
inline constexpr const char* kSurfaceFrames = "frames.json";

/// The mesh of exports, as text.
inline constexpr const char* kMeshText = "mesh.obj";

/// Default name of a saved map, which no later run removes.
inline constexpr const char* kMap = "map.plmap";

}  // namespace result_file

/// Files that a later run in the same folder replaces or removes; pictures and logs, in folders of their own, are not
/// among them.
inline constexpr std::array<const char*, 25> kResultFiles{result_file::kSummary,
                                                          result_file::kReport,
                                                          result_file::kTrajectory.tum,
                                                          result_file::kTrajectory.kitti,
                                                          result_file::kTrajectory.euroc,
                                                          result_file::kLiveTrajectory,
                                                          result_file::kKeyframes.tum,
                                                          result_file::kKeyframes.kitti,
                                                          result_file::kKeyframes.euroc,
                                                          result_file::kTruth,
                                                          result_file::kCovariances,
                                                          result_file::kMotionCovariances,
                                                          result_file::kFrameTable,
                                                          result_file::kBodies,
                                                          result_file::kLandmarks,
                                                          result_file::kCloud,
                                                          result_file::kMesh,
                                                          result_file::kOccupiedVoxels,
                                                          result_file::kVoxels,
                                                          result_file::kGrid,
                                                          result_file::kGridMetadata,
                                                          result_file::kDistances,
                                                          result_file::kHeights,
                                                          result_file::kPath,
                                                          result_file::kSurfaceFrames};

}  // namespace plslam
