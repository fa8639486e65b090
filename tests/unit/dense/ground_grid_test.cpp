// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/ground_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "dense_process/products.h"

namespace plslam::dense {
namespace {

constexpr double kCell_m = 0.1;

/// Keyframes of one session at these places on the x axis.
KeyframePoses At(const std::vector<double>& x_m) {
  KeyframePoses poses;
  for (size_t i = 0; i < x_m.size(); ++i) {
    poses[{SessionId(1), FrameId(static_cast<int64_t>(i))}] = SE3(Eigen::Quaterniond::Identity(), {x_m[i], 0.0, 0.0});
  }
  return poses;
}

bool HasPointNear(const std::vector<Eigen::Vector3d>& path, double x_m) {
  return std::ranges::any_of(path, [&](const Eigen::Vector3d& p) { return std::abs(p.x() - x_m) < 0.6 * kCell_m; });
}

TEST(PathOf, IsClosedBetweenNeighbours) {
  const std::vector<Eigen::Vector3d> path = PathOf(At({0.0, 1.0, 2.0}), kCell_m);
  for (double x = 0.0; x <= 2.0; x += kCell_m) EXPECT_TRUE(HasPointNear(path, x)) << x;
}

// Tracking was lost there, or the map has removed the keyframes: a wall may be in between.
TEST(PathOf, GapIsNotCrossed) {
  const std::vector<Eigen::Vector3d> path = PathOf(At({0.0, 5.0, 5.5}), kCell_m);
  EXPECT_TRUE(HasPointNear(path, 5.2));
  for (double x = 0.2; x <= 4.8; x += kCell_m) EXPECT_FALSE(HasPointNear(path, x)) << x;
}

TEST(GroundGrid, ObstaclesFitUnderTheRobotsHeight) {
  EXPECT_DOUBLE_EQ(LargestVoxelFor(0.15), 0.0);
  for (const double height_m : {0.2, 0.35, 0.5, 1.0}) {
    const double voxel_m = LargestVoxelFor(height_m);
    ASSERT_GT(voxel_m, 0.0);
    // A box as high as the robot on the floor z = 0, seen from above.
    Volume volume(voxel_m);
    for (int i = 0; i < 10; ++i) {
      std::vector<DepthRay> rays;
      for (double x = 0.0; x < 1.0; x += 0.5 * voxel_m) {
        for (double z = 0.0; z <= height_m; z += 0.5 * voxel_m) rays.push_back({{x, 2.0, z}, 1.0F, 100.0F, 1.0F});
      }
      volume.Integrate({0.5, 0.0, height_m + 0.2}, rays);
    }
    const GroundGrid grid = MakeGrid(volume, Floor(Surface(), voxel_m), height_m, {});
    EXPECT_GT(cv::countNonZero(grid.cells == OccupancyGrid::kOccupied), 0) << height_m;
  }
}

/// The ground below x = 0 to 2 m, y = 0 to 1 m, seen from above; `height_m` is that of the ground at x.
template <class Height>
Volume SeenFromAbove(const Height& height_m) {
  Volume volume(kCell_m / 2.0);
  for (int i = 0; i < 10; ++i) {
    std::vector<DepthRay> rays;
    for (double x = 0.0; x < 2.0; x += 0.25 * kCell_m) {
      for (double y = 0.0; y < 1.0; y += 0.25 * kCell_m) rays.push_back({{x, y, height_m(x)}, 1.0F, 100.0F, 1.0F});
    }
    volume.Integrate({1.0, 0.5, 1.5}, rays);
  }
  return volume;
}

uint8_t CellAt(const GroundGrid& grid, double x_m, double y_m) {
  const Eigen::Vector2i cell = grid.CellAt(x_m, y_m);
  return grid.cells.at<uint8_t>(cell.y(), cell.x());
}

TEST(GroundGrid, StairsDownAreNoFreeSpace) {
  const Volume stairs = SeenFromAbove([](double x) { return x < 1.0 ? 0.0 : -0.5; });
  const GroundGrid grid = MakeGrid(stairs, Floor(Surface(), stairs.voxel_m()), 1.0, {});
  for (const double y : {0.3, 0.5, 0.7}) {
    EXPECT_EQ(CellAt(grid, 0.5, y), OccupancyGrid::kFree) << y;
    EXPECT_EQ(CellAt(grid, 1.4, y), OccupancyGrid::kOccupied) << y;
  }
}

TEST(GroundGrid, ObstaclesOnThePathRemain) {
  Volume box(kCell_m / 2.0);
  for (int i = 0; i < 10; ++i) {
    std::vector<DepthRay> rays;
    for (double x = 0.2; x < 1.8; x += 0.25 * kCell_m) {
      for (double z = 0.1; z < 0.5; z += 0.25 * kCell_m) rays.push_back({{x, 0.5, z}, 1.0F, 100.0F, 1.0F});
    }
    box.Integrate({1.0, -1.0, 0.4}, rays);
  }
  std::vector<Eigen::Vector3d> path;
  for (double x = 0.0; x < 4.0; x += 0.05) path.emplace_back(x, 0.5, 0.6);
  const GroundGrid grid = MakeGrid(box, Floor(Surface(), box.voxel_m()), 1.0, path);
  const GroundGrid without = MakeGrid(box, Floor(Surface(), box.voxel_m()), 1.0, {});
  const auto n_occupied = [](const GroundGrid& of) { return cv::countNonZero(of.cells == OccupancyGrid::kOccupied); };
  EXPECT_GT(n_occupied(without), 0);
  EXPECT_EQ(n_occupied(grid), n_occupied(without));
  EXPECT_EQ(CellAt(grid, 3.0, 0.5), OccupancyGrid::kFree) << "not seen, but the camera was there";
}

TEST(Products, OctoMapThatEndsIsNamed) {
  Volume volume(0.05);
  const std::vector<DepthRay> ray{{{2000.0, 1.0, 0.0}, 1.0F, 100.0F, 1.0F}};
  for (int i = 0; i < 10; ++i) volume.Integrate({2000.0, 0.0, 0.0}, ray);
  const Products products{SE3(), {}, false, 0.0, {}, std::move(volume), {}, {}, {}};
  EXPECT_THROW(WriteProducts(testing::TempDir(), products, ProductKind::kOctoMap), std::runtime_error);
}

TEST(Products, SurfaceAboveTheCameraIsNoFloor) {
  const StereoCamera camera{
      .f_px = 60.0, .cx_px = 40.0, .cy_px = 30.0, .baseline_m = 0.1, .width_px = 80, .height_px = 60};
  const cv::Mat grey(camera.height_px, camera.width_px, CV_8U, cv::Scalar(90));
  DepthImage depth;
  depth.z_m = cv::Mat(camera.height_px, camera.width_px, CV_32F, cv::Scalar(2.0));
  depth.sigma_m = cv::Mat(camera.height_px, camera.width_px, CV_32F, cv::Scalar(0.01));
  const KeyframePoses poses = At({0.0, 0.01, 0.02, 0.03, 0.04});
  DenseMap map(0.05, 0.0);
  for (const auto& [name, pose] : poses) ASSERT_TRUE(map.Add(name, depth, grey, camera, poses));
  // A plane ahead: the floor of a camera that looks down, the ceiling of one that looks up.
  const auto with_up = [&](const Eigen::Vector3d& up_w) {
    return MakeProducts(map, poses, {up_w, VerticalSource::kGiven}, PathOf(poses, 0.05), 1.0);
  };
  EXPECT_TRUE(with_up(-Eigen::Vector3d::UnitZ()).has_floor);
  EXPECT_NEAR(with_up(-Eigen::Vector3d::UnitZ()).floor_m, -2.0, 0.05);
  EXPECT_FALSE(with_up(Eigen::Vector3d::UnitZ()).has_floor);
}

TEST(GroundGrid, TooManyCellsAreNamed) {
  Volume volume(0.01);
  const std::vector<DepthRay> ray{{{0.0, 1.0, 0.0}, 1.0F, 100.0F, 1.0F}};
  volume.Integrate({0.0, 0.0, 0.0}, ray);
  const std::vector<Eigen::Vector3d> path{{0.0, 0.0, 0.0}, {1000.0, 1000.0, 0.0}};
  EXPECT_THROW(MakeGrid(volume, Floor(Surface(), 0.01), 1.0, path), std::runtime_error);
}

}  // namespace
}  // namespace plslam::dense
