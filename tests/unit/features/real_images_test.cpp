// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "core/features/points/orb_extractor.h"
#include "core/io/images/image_file.h"
#include "tests/support/data_folder.h"
#include "tests/unit/stereo/stereo_points.h"

namespace plslam {
namespace {

TEST(OrbExtractor, EveryQuadrantOfAStreetHasItsShare) {
  PLSLAM_REQUIRE_DATA(folder, "kitti_03");
  const cv::Mat image = ReadGreyImage(folder / "image_0" / "000000.png");
  ASSERT_FALSE(image.empty());
  const std::vector<PointFeature> points = OrbExtractor{OrbOptions{}}.Extract(image);
  EXPECT_GE(points.size(), 950U);
  std::array<int, 4> share{};
  for (const PointFeature& p : points) {
    ++share[(p.px.x() > image.cols / 2.0 ? 1 : 0) + (p.px.y() > image.rows / 2.0 ? 2 : 0)];
  }
  for (const int n : share) EXPECT_GE(n, 150) << "of " << points.size();
}

class RealPair : public testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(RealPair, ShareOfPointsWithDepth) {
  PLSLAM_REQUIRE_DATA(folder, GetParam().first);
  for (const char* name : {"000000.png", "000005.png"}) {
    const cv::Mat left = ReadGreyImage(folder / "image_0" / name);
    const cv::Mat right = ReadGreyImage(folder / "image_1" / name);
    ASSERT_FALSE(left.empty());
    EXPECT_GE(test::ShareWithDepth(test::Match(left, right)), GetParam().second) << folder << " " << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Data, RealPair,
                         testing::Values(std::pair("kitti_03", 0.55), std::pair("sand_rand", 0.5),
                                         std::pair("tsukuba_lamps_a", 0.6), std::pair("tartanair2_10", 0.4)),
                         [](const auto& test) { return std::string(test.param.first); });

}  // namespace
}  // namespace plslam
