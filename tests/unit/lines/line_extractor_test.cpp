// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_extractor.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/lines/rendered_edges.h"

namespace plslam {
namespace {

bool Same(const std::vector<LineFeature>& a, const std::vector<LineFeature>& b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i].segment.p != b[i].segment.p || a[i].segment.q != b[i].segment.q) return false;
    if (a[i].descriptor != b[i].descriptor || a[i].response != b[i].response) return false;
  }
  return true;
}

/// Rendered once: under a sanitizer that takes seconds.
const cv::Mat& ManyBars() {
  static const cv::Mat image = [] {
    std::vector<test::Bar> bars;
    for (int i = 0; i < 12; ++i) {
      for (int j = 0; j < 5; ++j) {
        const Eigen::Vector2d middle(30.0 + 32 * i, 30.0 + 45 * j);
        const Eigen::Vector2d half(16.0 * std::cos(0.7 * i + j), 16.0 * std::sin(0.7 * i + j));
        bars.push_back({{middle - half, middle + half}, 7, 150.0 + 5 * j});
      }
    }
    return test::RenderBars({420, 250}, 80, bars);
  }();
  return image;
}

TEST(LineExtractor, EqualImagesGiveEqualLines) {
  const cv::Mat& image = ManyBars();
  for (const auto& [name, detector] : ChoicesOf(Segments())) {
    LineOptions options;
    options.detector = detector;
    LineExtractor fresh(options);
    LineExtractor used(options);
    used.Extract(test::NoiseImage({333, 222}, 100, 30, 1));
    const auto first = fresh.Extract(image);
    EXPECT_GE(first.size(), 60U) << name;
    EXPECT_TRUE(Same(first, used.Extract(image))) << name;
    EXPECT_TRUE(Same(first, fresh.Extract(image.clone()))) << name;
  }
}

TEST(LineExtractor, KeepsMinimumLengthAndMaximumNumber) {
  LineOptions options;
  options.max_lines = 17;
  options.min_length_px = 25;
  const auto lines = LineExtractor(options).Extract(ManyBars());
  EXPECT_EQ(lines.size(), 17U);
  for (const LineFeature& l : lines) EXPECT_GE(l.segment.Length(), 25.0);
  options.max_lines = 0;
  EXPECT_TRUE(LineExtractor(options).Extract(ManyBars()).empty());
}

TEST(LineExtractor, NoTwoLinesOnOneEdge) {
  const auto lines = LineExtractor(LineOptions()).Extract(ManyBars());
  for (size_t i = 0; i < lines.size(); ++i) {
    for (size_t j = i + 1; j < lines.size(); ++j) {
      const Segment2& a = lines[i].segment;
      const Segment2& b = lines[j].segment;
      const double distance = (a.p - b.p).norm() + (a.q - b.q).norm();
      EXPECT_GT(distance, 4.0) << i << " and " << j;
    }
  }
}

TEST(LineExtractor, InterruptedEdgeIsOneLine) {
  cv::Mat image = test::RenderEdge({200, 100}, {{0, 50.3}, {200, 58.3}}, 60, 150);
  // A post in front, six pixels wide.
  image.colRange(100, 106).setTo(60);
  const auto lines = LineExtractor(LineOptions()).Extract(image);
  double longest = 0.0;
  for (const LineFeature& l : lines) longest = std::max(longest, l.segment.Length());
  EXPECT_GT(longest, 180.0);
}

TEST(LineExtractor, CornerIsTwoLines) {
  const cv::Mat image = test::RenderBars({160, 160}, 70, {{{{30, 80.5}, {130, 80.5}}, 100, 170}});
  const auto lines = LineExtractor(LineOptions()).Extract(image);
  EXPECT_EQ(lines.size(), 4U);
  for (const LineFeature& l : lines) EXPECT_NEAR(l.segment.Length(), 98.0, 5.0);
}

TEST(LineExtractor, ColourImageIsRefused) {
  EXPECT_THROW(LineExtractor(LineOptions()).Extract(cv::Mat(20, 20, CV_8UC3)), std::invalid_argument);
}

}  // namespace
}  // namespace plslam
