// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/points/orb_extractor.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/features/matching/descriptor_matcher.h"
#include "tests/unit/features/texture.h"

namespace plslam {
namespace {

void ExpectEqual(const std::vector<PointFeature>& a, const std::vector<PointFeature>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].px, b[i].px);
    EXPECT_EQ(a[i].descriptor, b[i].descriptor);
    EXPECT_EQ(a[i].angle_rad, b[i].angle_rad);
  }
}

TEST(OrbExtractor, AnySizeFromOnePixelUp) {
  OrbExtractor extractor{OrbOptions{}};
  for (const int width : {1, 2, 7, 31, 33, 34, 60, 200}) {
    for (const int height : {1, 8, 33, 50}) {
      const cv::Mat image = test::RandomImage(width, height, 1);
      for (const PointFeature& p : extractor.Extract(image)) {
        EXPECT_TRUE(p.px.x() >= 0 && p.px.y() >= 0 && p.px.x() < width && p.px.y() < height) << p.px.transpose();
      }
    }
  }
  EXPECT_TRUE(extractor.Extract(cv::Mat()).empty());
}

TEST(OrbExtractor, BlackAndSaturatedImagesGiveNothing) {
  OrbExtractor extractor{OrbOptions{}};
  EXPECT_TRUE(extractor.Extract(cv::Mat(120, 160, CV_8UC1, cv::Scalar(0))).empty());
  EXPECT_TRUE(extractor.Extract(cv::Mat(120, 160, CV_8UC1, cv::Scalar(255))).empty());
}

TEST(OrbExtractor, AnotherPixelTypeIsRefused) {
  OrbExtractor extractor{OrbOptions{}};
  EXPECT_THROW(extractor.Extract(cv::Mat(50, 50, CV_16UC1, cv::Scalar(0))), std::invalid_argument);
}

TEST(OrbExtractor, NeverMoreThanMaxPoints) {
  for (const int max_points : {0, 1, 10, 300}) {
    OrbOptions options;
    options.max_points = max_points;
    EXPECT_LE(static_cast<int>(OrbExtractor(options).Extract(test::RandomImage(320, 240, 2)).size()), max_points);
  }
}

TEST(OrbExtractor, EqualImagesGiveEqualPoints) {
  const cv::Mat image = test::RenderTexture(240, 180, {});
  OrbExtractor used{OrbOptions{}};
  used.Extract(test::RandomImage(301, 97, 3));
  used.Extract(test::RenderTexture(240, 180, {}, 2));
  ExpectEqual(used.Extract(image), OrbExtractor{OrbOptions{}}.Extract(image));
  ExpectEqual(used.Extract(image), used.Extract(image.clone()));
}

TEST(OrbExtractor, ShiftedTextureIsFoundAgainToAFractionOfAPixel) {
  OrbExtractor extractor{OrbOptions{}};
  const test::View moved{.shift_x_px = 3.3, .shift_y_px = -1.6};
  const std::vector<PointFeature> a = extractor.Extract(test::RenderTexture(400, 300, {}));
  const std::vector<PointFeature> b = extractor.Extract(test::RenderTexture(400, 300, moved));
  const std::vector<int> matches = MatchPointsBruteForce(a, b, {});
  std::vector<double> errors;
  for (size_t i = 0; i < a.size(); ++i) {
    if (matches[i] < 0) continue;
    errors.push_back((a[i].px - Eigen::Vector2d(3.3, -1.6) - b[matches[i]].px).norm() / a[i].scale);
  }
  ASSERT_GT(errors.size(), a.size() / 3) << "of " << a.size();
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.35) << "median error in pixels of the octave";
}

}  // namespace
}  // namespace plslam
