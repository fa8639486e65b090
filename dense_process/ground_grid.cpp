// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/ground_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace plslam::dense {
namespace {

constexpr double kLowestObstacle_m = 0.1;
constexpr double kLowestInVoxels = 1.5;  // the floor itself is that rough
constexpr double kLeastHeight_m = 0.1;   // of an obstacle
constexpr double kLeastFree_m = 0.15;    // of observed free space in a column without a floor
// A column without a floor has a drop from so many heights of the lowest obstacle below the floor around it.
constexpr double kDrop = 2.0;
constexpr double kSmallest_m2 = 0.025;  // ten cells of 5 cm

struct Column {
  float floor_m = std::numeric_limits<float>::quiet_NaN();
  float top_m = 0.0F;
  uint16_t n_occupied = 0;
  uint16_t n_free = 0;
  bool has_floor = false;
  bool has_ground_below = false;
  uint16_t n_free_below = 0;

  bool IsDrop() const { return !has_floor && has_ground_below; }
  bool IsFree(double voxel_m) const {
    const auto is_enough = [voxel_m](int n) { return n * voxel_m >= kLeastFree_m - 1e-9; };
    return has_floor || (is_enough(n_free) && !is_enough(n_free_below) && !has_ground_below);
  }
};

/// Height above the floor from which on there are obstacles.
double LowestObstacle_m(double voxel_m) { return std::max(kLowestObstacle_m, kLowestInVoxels * voxel_m); }

/// Obstacles of fewer cells are ignored.
void RemoveSmall(cv::Mat& cells, const cv::Mat& free, double cell_m) {
  const int least = static_cast<int>(std::ceil(kSmallest_m2 / (cell_m * cell_m) - 1e-6));
  cv::Mat labels, stats, centres;
  const int n = cv::connectedComponentsWithStats(cells == OccupancyGrid::kOccupied, labels, stats, centres, 8);
  for (int y = 0; y < cells.rows; ++y) {
    for (int x = 0; x < cells.cols; ++x) {
      const int label = labels.at<int>(y, x);
      if (label == 0 || label >= n || stats.at<int>(label, cv::CC_STAT_AREA) >= least) continue;
      cells.at<uint8_t>(y, x) = free.at<uint8_t>(y, x) != 0 ? OccupancyGrid::kFree : OccupancyGrid::kUnknown;
    }
  }
}

}  // namespace

Content ContentOf(const Volume::Voxel& voxel, double voxel_m) {
  if (voxel.weight < kLeastKnown || voxel.distance_m < -voxel_m) return Content::kUnknown;
  return voxel.distance_m < 0.5 * voxel_m ? Content::kOccupied : Content::kFree;
}

double LargestVoxelFor(double robot_height_m) {
  // From the floor's roughness on, whole voxels that make up the height of an obstacle.
  const auto fits = [&](double voxel_m) {
    return LowestObstacle_m(voxel_m) + std::ceil(kLeastHeight_m / voxel_m - 1e-9) * voxel_m <= robot_height_m + 1e-9;
  };
  double largest_m = 0.0;
  for (int i = 1; i <= 100; ++i) {
    if (fits(0.01 * i)) largest_m = 0.01 * i;
  }
  return largest_m;
}

Eigen::Vector2i GroundGrid::CellAt(double x_m, double y_m) const {
  return {static_cast<int>(std::floor((x_m - origin_m.x()) / cell_m + 1e-9)),
          static_cast<int>(std::floor((y_m - origin_m.y()) / cell_m + 1e-9))};
}

GroundGrid MakeGrid(const Volume& volume, const Floor& floor, double robot_height_m,
                    std::span<const Eigen::Vector3d> path) {
  const double v = volume.voxel_m();
  const double lowest_m = LowestObstacle_m(v);
  Eigen::Vector2i low = Eigen::Vector2i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector2i high = Eigen::Vector2i::Constant(std::numeric_limits<int>::min());
  const auto include = [&](const Eigen::Vector2i& cell) {
    low = low.cwiseMin(cell);
    high = high.cwiseMax(cell);
  };
  volume.Visit([&](const Volume::Voxel& voxel) { include(voxel.index.head<2>()); });
  const auto cell_of = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector2i(static_cast<int>(std::floor(p.x() / v)), static_cast<int>(std::floor(p.y() / v)));
  };
  for (const Eigen::Vector3d& p : path) include(cell_of(p));
  GroundGrid grid;
  grid.cell_m = v;
  if (low.x() > high.x()) return grid;
  const int width = high.x() - low.x() + 1;
  const int height = high.y() - low.y() + 1;
  if (int64_t{width} * height > kMostCells) {
    throw std::runtime_error(
        fmt::format("no grid: {} x {} cells of {} m are more than {} million; choose larger ones (dense.voxel_m)",
                    width, height, v, kMostCells / 1'000'000));
  }
  grid.origin_m = v * low.cast<double>();
  std::vector<Column> columns(static_cast<size_t>(width) * static_cast<size_t>(height));
  const auto column_at = [&](const Eigen::Vector2i& cell) -> Column& {
    return columns[static_cast<size_t>(cell.y() - low.y()) * static_cast<size_t>(width) +
                   static_cast<size_t>(cell.x() - low.x())];
  };
  volume.Visit([&](const Volume::Voxel& voxel) {
    const Content content = ContentOf(voxel, v);
    if (content == Content::kUnknown) return;
    const Eigen::Vector3d p = volume.Centre(voxel.index) + Eigen::Vector3d::Constant(0.5 * v);
    Column& column = column_at(voxel.index.head<2>());
    if (std::isnan(column.floor_m)) column.floor_m = static_cast<float>(floor.HeightAt(p.x(), p.y()));
    const double above_m = p.z() - column.floor_m;
    if (std::abs(above_m) < lowest_m) {
      column.has_floor = column.has_floor || content == Content::kOccupied;
    } else if (above_m > 0.0 && above_m <= robot_height_m) {
      ++(content == Content::kOccupied ? column.n_occupied : column.n_free);
      if (content == Content::kOccupied) column.top_m = std::max(column.top_m, static_cast<float>(above_m + 0.5 * v));
    } else if (above_m < -kDrop * lowest_m) {
      if (content == Content::kOccupied) column.has_ground_below = true;
      if (content == Content::kFree) ++column.n_free_below;
    }
  });
  grid.cells = cv::Mat(height, width, CV_8UC1, cv::Scalar(OccupancyGrid::kUnknown));
  grid.height_m = cv::Mat(height, width, CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  cv::Mat free = cv::Mat::zeros(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Column& column = columns[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
      const bool is_free = column.IsFree(v);
      free.at<uint8_t>(y, x) = is_free ? 255 : 0;
      if (column.IsDrop() || column.n_occupied * v >= kLeastHeight_m - 1e-9) {
        grid.cells.at<uint8_t>(y, x) = OccupancyGrid::kOccupied;
      } else if (is_free) {
        grid.cells.at<uint8_t>(y, x) = OccupancyGrid::kFree;
      }
    }
  }
  for (const Eigen::Vector3d& p : path) {
    const Eigen::Vector2i cell = cell_of(p) - low;
    uint8_t& content = grid.cells.at<uint8_t>(cell.y(), cell.x());
    if (content == OccupancyGrid::kUnknown) content = OccupancyGrid::kFree;
  }
  RemoveSmall(grid.cells, free, v);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const uint8_t cell = grid.cells.at<uint8_t>(y, x);
      if (cell == OccupancyGrid::kUnknown) continue;
      const Column& column = columns[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
      grid.height_m.at<float>(y, x) = cell == OccupancyGrid::kOccupied ? column.top_m : 0.0F;
    }
  }
  cv::distanceTransform(grid.cells != OccupancyGrid::kOccupied, grid.distance_m, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  grid.distance_m *= v;
  return grid;
}

}  // namespace plslam::dense
