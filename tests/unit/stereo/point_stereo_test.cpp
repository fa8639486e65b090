// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/point_stereo.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/features/points/orb_extractor.h"
#include "tests/unit/features/texture.h"
#include "tests/unit/stereo/stereo_points.h"

namespace plslam::vo {
namespace {

using test::Match;
using test::ShareWithDepth;

TEST(MatchPointsStereo, KnownDisparityWithNoiseAndTwiceTheExposure) {
  const double truth = 18.37;
  const cv::Mat left = test::RenderTexture(480, 320, {.gain = 0.6, .noise = 2.0, .noise_seed = 1}, 7, 1.5);
  const cv::Mat right =
      test::RenderTexture(480, 320, {.shift_x_px = truth, .gain = 1.2, .noise = 2.0, .noise_seed = 2}, 7, 1.5);
  const std::vector<StereoPoint> points = Match(left, right);
  ASSERT_GT(points.size(), 300U);
  EXPECT_GT(ShareWithDepth(points), 0.6);
  int wrong = 0;
  int matched = 0;
  double sum = 0.0;
  for (const StereoPoint& p : points) {
    if (!p.HasDepth()) continue;
    ++matched;
    const double normalised = (p.disparity_px - truth) / p.sigma_disparity_px;
    if (std::abs(p.disparity_px - truth) > 1.0) ++wrong;
    if (std::abs(normalised) < 5.0) sum += normalised * normalised;
  }
  EXPECT_LE(wrong, matched / 200) << "of " << matched;
  EXPECT_LT(std::sqrt(sum / matched), 1.4);
  EXPECT_GT(std::sqrt(sum / matched), 0.3);
}

TEST(MatchPointsStereo, WithoutDirectSearchOnlyCornersMatch) {
  const cv::Mat left = test::RenderTexture(480, 320, {}, 8);
  const cv::Mat right = test::RenderTexture(480, 320, {.shift_x_px = 11.6}, 8);
  StereoOptions corners_only;
  corners_only.point_direct = false;
  const double corners = ShareWithDepth(Match(left, right, corners_only));
  const double both = ShareWithDepth(Match(left, right));
  EXPECT_GT(corners, 0.2);
  EXPECT_GT(both, corners);
}

TEST(MatchPointsStereo, IdenticalImagesHaveNoDepth) {
  const cv::Mat image = test::RenderTexture(320, 240, {});
  for (const StereoPoint& p : Match(image, image)) EXPECT_FALSE(p.HasDepth()) << p.disparity_px;
}

TEST(MatchPointsStereo, RepeatedTextureHasNoDepth) {
  cv::Mat squares(240, 400, CV_8UC1, cv::Scalar(50));
  for (int y = 12; y < 220; y += 32) {
    for (int x = 8; x < 380; x += 32) squares(cv::Rect(x, y, 16, 16)).setTo(200);
  }
  const std::vector<StereoPoint> points = Match(squares, squares);
  ASSERT_GT(points.size(), 100U);
  EXPECT_LE(ShareWithDepth(points), 0.02);
}

// Repeats every 47.8 px, so the true disparity lies between pixels where a wrong one lies on a pixel.
TEST(MatchPointsStereo, RepetitionBetweenPixelsIsAmbiguous) {
  constexpr double kPeriod_px = 47.8;
  constexpr double kTruth_px = 7.47;
  const auto render = [](double shift_px) {
    cv::Mat image(240, 400, CV_8UC1);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        double grey = 128.0;
        for (int k = 1; k <= 10; ++k) {
          const double phase = 1.7 * k * k + 2.0 * std::sin(y / (7.0 + 1.3 * k));
          grey += 11.0 * std::cos(2.0 * M_PI * k * (x + shift_px) / kPeriod_px + phase);
        }
        image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(grey);
      }
    }
    return image;
  };
  const std::vector<StereoPoint> points = Match(render(0.0), render(kTruth_px));
  ASSERT_GT(points.size(), 100U);
  size_t wrong = 0;
  size_t ambiguous = 0;
  for (const StereoPoint& p : points) {
    if (p.HasDepth() && std::abs(p.disparity_px - kTruth_px) > 1.0) ++wrong;
    if (p.is_ambiguous) ++ambiguous;
    EXPECT_FALSE(p.is_ambiguous && p.HasDepth());
  }
  EXPECT_LE(wrong, points.size() / 50) << "of " << points.size();
  EXPECT_GT(ambiguous, points.size() / 3) << "of " << points.size();
}

TEST(MatchPointsStereo, ZeroAndOneFeature) {
  const cv::Mat left = test::RenderTexture(200, 120, {});
  const cv::Mat right = test::RenderTexture(200, 120, {.shift_x_px = 9.0});
  const StereoOptions options;
  std::vector<StereoPoint> none;
  Match(none, OrbExtractor{OrbOptions{}}.Extract(right), left, right, options);
  EXPECT_TRUE(none.empty());
  PointFeature feature;
  feature.px = {100.0, 60.0};
  std::vector<StereoPoint> one = WithoutDepth({feature}, options);
  Match(one, {}, left, right, options);
  ASSERT_TRUE(one[0].HasDepth());
  EXPECT_NEAR(one[0].disparity_px, 9.0, 0.1);
}

TEST(MatchPointsStereo, UnrelatedImagesHardlyMatch) {
  const cv::Mat left = test::RenderTexture(320, 240, {}, 11);
  const cv::Mat right = test::RenderTexture(320, 240, {}, 12);
  EXPECT_LT(ShareWithDepth(Match(left, right)), 0.02);
}

TEST(WithoutDepth, SigmaGrowsWithTheScale) {
  PointFeature fine;
  PointFeature coarse;
  coarse.scale = 2.0;
  const std::vector<StereoPoint> points = WithoutDepth({fine, coarse}, {});
  EXPECT_FALSE(points[0].HasDepth());
  EXPECT_DOUBLE_EQ(points[1].sigma_px, 2.0 * points[0].sigma_px);
}

}  // namespace
}  // namespace plslam::vo
