// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/map/occupancy_grid.h"
#include "dense_process/level_frame.h"
#include "dense_process/volume.h"

namespace plslam::dense {

/// Content of a voxel, for planners.
enum class Content { kUnknown, kFree, kOccupied };

/// Occupied: within half a voxel in front of a surface and one behind it. Unknown: hardly observed, or deeper inside.
Content ContentOf(const Volume::Voxel& voxel, double voxel_m);

/// A map of the floor for a robot: columns of voxels between the floor and the robot's height.
struct GroundGrid {
  double cell_m = 0.0;
  /// Lower left corner of the lower left cell, in the level frame.
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();
  cv::Mat cells;       ///< CV_8UC1, values of OccupancyGrid; row 0 has the smallest y
  cv::Mat height_m;    ///< CV_32FC1: top of the highest obstacle, or the floor, above the floor; NaN in unknown cells
  cv::Mat distance_m;  ///< CV_32FC1: to the nearest obstacle

  /// Returns the cell that contains a point of the level frame; it may be outside the grid.
  Eigen::Vector2i CellAt(double x_m, double y_m) const;
};

/// Makes the grid of a volume whose voxel (i, j, k) has its centre at voxel_m * (i + 0.5, j + 0.5, k + 0.5) of the level
/// frame. A cell is occupied with obstacles of at least 0.1 m of height between 0.1 m (or 1.5 voxels) above the floor
/// and `robot_height_m`, or without a floor but with ground from 0.2 m (or 3 voxels) below it on: stairs, the edge of a
/// platform. It is free if its floor was observed, or enough of the space above, and no free space below. Obstacles of less
/// than 250 cm^2 of ground (ten cells of 5 cm) are ignored. Other cells of `path` (positions of the camera in the level
/// frame) are free: the camera was there.
///
/// Throws std::runtime_error, in one sentence with the remedy, if the space has more than `kMostCells` cells.
GroundGrid MakeGrid(const Volume& volume, const Floor& floor, double robot_height_m,
                    std::span<const Eigen::Vector3d> path);

inline constexpr int64_t kMostCells = 100'000'000;

/// Largest voxels at which an obstacle of 0.1 m fits between the floor and a robot of this height; 0: there are none.
double LargestVoxelFor(double robot_height_m);

}  // namespace plslam::dense
