// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/surface_cloud.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace plslam {
namespace {

constexpr double kVoxel_m = 0.05;

/// A wall of 20 x 20 points.
std::vector<SurfacePoint> Wall(float z_m) {
  std::vector<SurfacePoint> points;
  for (int i = 0; i < 400; ++i) {
    points.push_back({{0.05F * static_cast<float>(i % 20), 0.05F * static_cast<float>(i / 20), z_m},
                      RoundedNormal({0.0F, 0.0F, -1.0F}),
                      100});
  }
  return points;
}

TEST(SurfaceCloud, PointsOfAMovedSubmap) {
  SurfaceCloud cloud;
  const Eigen::AngleAxisd turn(M_PI / 2.0, Eigen::Vector3d::UnitX());
  cloud.submaps[3] = {1, 7, SE3(Eigen::Quaterniond(turn), {0.0, 0.0, 5.0}), {Wall(2.0F).front()}};
  const std::vector<SurfacePoint> points = cloud.PointsInW();
  ASSERT_EQ(points.size(), 1U);
  EXPECT_LT((points[0].p - Eigen::Vector3f(0.0F, -2.0F, 5.0F)).norm(), 1e-6F);
  EXPECT_LT((UnitNormal(points[0]) - Eigen::Vector3f(0.0F, 1.0F, 0.0F)).norm(), 0.01F);
  EXPECT_EQ(points[0].grey, 100);
}

TEST(SurfaceCloud, MorePreciseIsNotAnother) {
  EXPECT_FALSE(HasOtherSurfaces(Wall(2.0F), Wall(2.0F), kVoxel_m, 10));
  EXPECT_FALSE(HasOtherSurfaces(Wall(1.999F), Wall(2.001F), kVoxel_m, 10)) << "cubes have their border here";
  EXPECT_TRUE(HasOtherSurfaces(Wall(2.0F), Wall(2.2F), kVoxel_m, 10));
}

TEST(SurfaceCloud, ObstacleThatCameOrWentIsAnother) {
  std::vector<SurfacePoint> with = Wall(2.0F);
  for (int i = 0; i < 9; ++i) with.push_back({{0.05F * static_cast<float>(i), 0.0F, 1.0F}, {}, 0});
  EXPECT_FALSE(HasOtherSurfaces(Wall(2.0F), with, kVoxel_m, 10)) << "nine points are too few";
  with.push_back({{0.0F, 0.5F, 1.0F}, {}, 0});
  EXPECT_TRUE(HasOtherSurfaces(Wall(2.0F), with, kVoxel_m, 10));
  EXPECT_TRUE(HasOtherSurfaces(with, Wall(2.0F), kVoxel_m, 10));
}

}  // namespace
}  // namespace plslam
