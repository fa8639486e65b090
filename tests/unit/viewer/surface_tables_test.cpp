// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/surface_tables.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/io/images/png_codec.h"
#include "tests/unit/viewer/report_columns.h"

namespace plslam::viewer {
namespace {

/// Both sides of a wall of 2 cm, 5 m x 5 m.
SurfaceCloud ThinWall() {
  SurfaceCloud cloud{0.05, {}};
  SubmapCloud& submap = cloud.submaps[0];
  for (int i = 0; i < 10'000; ++i) {
    const float x = 0.05F * static_cast<float>(i % 100), y = 0.05F * static_cast<float>(i / 100);
    submap.points.push_back({{x, y, 0.0F}, RoundedNormal({0.0F, 0.0F, -1.0F}), 50});
    submap.points.push_back({{x, y, 0.02F}, RoundedNormal({0.0F, 0.0F, 1.0F}), 200});
  }
  return cloud;
}

TEST(SurfaceTables, PointsKeepTheirPlaces) {
  const SurfaceCloud cloud = ThinWall();
  const ReportSurfaces surfaces = SurfaceTables(cloud, {}, {});
  const auto p = Numbers<uint16_t>(surfaces.points, "p");
  ASSERT_EQ(p.size(), 3U * 20'000U);
  EXPECT_EQ(surfaces.spacing_m, 0.05);
  EXPECT_FALSE(surfaces.grid);
  for (size_t i = 0; i < 20'000; ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(surfaces.low_w[k] + surfaces.step_m * p[3 * i + static_cast<size_t>(k)],
                  cloud.submaps.at(0).points[i].p[k], 1e-4);
    }
  }
  EXPECT_EQ(Numbers<uint8_t>(surfaces.points, "normal")[2], 1);
  EXPECT_EQ(Numbers<uint8_t>(surfaces.points, "normal")[5], 255);
}

TEST(SurfaceTables, FewerPointsKeepBothSidesOfAWall) {
  const ThinnedCloud thinned = Thin(ThinWall().PointsInW(), 0.05, 3000);
  EXPECT_LE(thinned.points.size(), 3000U);
  EXPECT_GT(thinned.points.size(), 1000U);
  EXPECT_GT(thinned.spacing_m, 0.1);
  EXPECT_LT(thinned.spacing_m, 0.3);
  const auto n_front = std::ranges::count_if(thinned.points, [](const SurfacePoint& point) {
    EXPECT_EQ(std::abs(point.normal[2]), 127);
    EXPECT_EQ(point.grey, point.normal[2] < 0 ? 50 : 200);
    return point.normal[2] < 0;
  });
  EXPECT_EQ(n_front, static_cast<int64_t>(thinned.points.size()) / 2);
}

OccupancyGrid SmallGrid() {
  // Unknown around 3 x 2 cells, of which the lower left one is occupied.
  OccupancyGrid grid{SE3(Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0}), -1.5, 0.1, -4, 6, 8, 5, {}};
  grid.cells.assign(40, OccupancyGrid::kUnknown);
  for (int y = 1; y < 3; ++y) {
    for (int x = 2; x < 5; ++x) grid.cells[static_cast<size_t>(8 * y + x)] = OccupancyGrid::kFree;
  }
  grid.cells[8 + 2] = OccupancyGrid::kOccupied;
  return grid;
}

cv::Mat PictureOf(const ReportGrid& grid) {
  return DecodePng({reinterpret_cast<const uint8_t*>(grid.png.data()), grid.png.size()},
                   {grid.width_px, grid.height_px});
}

TEST(SurfaceTables, GridIsAPictureOfItsKnownPart) {
  const std::optional<ReportGrid> grid = SurfaceTables({}, SmallGrid(), {}).grid;
  ASSERT_TRUE(grid);
  EXPECT_EQ(cv::Size(grid->width_px, grid->height_px), cv::Size(3, 2));
  EXPECT_EQ(grid->pixel_m, 0.1);
  EXPECT_LT((grid->corner_level - Eigen::Vector3d(-0.2, 0.7, -1.5)).norm(), 1e-12);
  EXPECT_EQ(grid->T_w_level.translation().x(), 1.0);
  const cv::Mat picture = PictureOf(*grid);
  EXPECT_EQ(picture.at<uint8_t>(1, 0), OccupancyGrid::kOccupied) << "the last row has the smallest y";
  EXPECT_EQ(picture.at<uint8_t>(0, 0), OccupancyGrid::kFree);
}

TEST(SurfaceTables, LargeGridIsReducedAndKeepsObstacles) {
  const std::optional<ReportGrid> grid = SurfaceTables({}, SmallGrid(), {.grid_px = 2}).grid;
  ASSERT_TRUE(grid);
  EXPECT_EQ(cv::Size(grid->width_px, grid->height_px), cv::Size(2, 1));
  EXPECT_EQ(grid->pixel_m, 0.2);
  const cv::Mat picture = PictureOf(*grid);
  EXPECT_EQ(picture.at<uint8_t>(0, 0), OccupancyGrid::kOccupied);
  EXPECT_EQ(picture.at<uint8_t>(0, 1), OccupancyGrid::kFree);
}

}  // namespace
}  // namespace plslam::viewer
