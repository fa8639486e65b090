// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/segment_tracker.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "core/features/lines/line_extractor.h"
#include "core/features/lines/line_sigma.h"
#include "tests/unit/lines/rendered_edges.h"

namespace plslam::vo {
namespace {

const cv::Size kSize(220, 160);

/// A bar that leans by `lean_px`, shifted to the right.
cv::Mat Bar(double lean_px, double shift_px, double noise, uint32_t seed, double grey = 150.0) {
  const test::Bar bar{{{100.0 + shift_px, 20.0}, {100.0 + shift_px + lean_px, 140.0}}, 16, grey};
  cv::Mat image = test::RenderBars(kSize, 80, {bar});
  if (noise > 0.0) test::AddNoise(image, noise, seed);
  return image;
}

std::vector<LineFeature> Detected(const cv::Mat& image) {
  LineExtractor extractor{LineOptions()};
  std::vector<LineFeature> lines = extractor.Extract(image);
  std::erase_if(lines, [](const LineFeature& line) { return line.octave > 0 || line.segment.Length() < 60.0; });
  return lines;
}

Segment2 Shifted(const Segment2& s, double x_px) {
  return {s.p + Eigen::Vector2d(x_px, 0.0), s.q + Eigen::Vector2d(x_px, 0.0)};
}

TEST(SegmentTracker, LocatesAnEdgeAsTheDetectorDoes) {
  for (const double lean_px : {0.0, 7.0, -30.0, 100.0}) {
    const cv::Mat image = Bar(lean_px, 0.0, 0.0, 0);
    const auto lines = Detected(image);
    ASSERT_GE(lines.size(), 2U) << lean_px;
    for (const LineFeature& line : lines) {
      const auto found = LocateSegment(image, line, Shifted(line.segment, 1.3));
      ASSERT_TRUE(found) << lean_px;
      const Eigen::Vector3d edge = LineThrough(line.segment);
      EXPECT_LT(std::abs(edge.dot(found->segment.p.homogeneous())), 0.05) << lean_px;
      EXPECT_LT(std::abs(edge.dot(found->segment.q.homogeneous())), 0.05) << lean_px;
      EXPECT_NEAR(found->response, line.response, 0.1 * line.response);
    }
  }
}

TEST(SegmentTracker, ErrorsAreThoseOfDetectedSegments) {
  double squares = 0.0;
  int count = 0;
  for (uint32_t i = 0; i < 40; ++i) {
    const double lean_px = 2.0 * i - 40.0;
    const auto lines = Detected(Bar(lean_px, 0.0, 0.0, 0, 95.0));
    const cv::Mat now = Bar(lean_px, 0.7, 2.0, i + 1, 95.0);
    for (const LineFeature& line : lines) {
      const Segment2 truth = Shifted(line.segment, 0.7);
      const auto found = LocateSegment(now, line, Shifted(truth, 0.8));
      if (!found) continue;
      const Eigen::Vector3d edge = LineThrough(truth);
      for (const Eigen::Vector2d& end : {found->segment.p, found->segment.q}) {
        squares += std::pow(edge.dot(end.homogeneous()) / EndSigma_px(*found), 2);
        ++count;
      }
    }
  }
  ASSERT_GE(count, 120);
  const double normalised = std::sqrt(squares / count);
  EXPECT_GT(normalised, 0.6);
  EXPECT_LT(normalised, 1.4);
}

TEST(SegmentTracker, OtherEdgesAreNotTaken) {
  const auto lines = Detected(Bar(5.0, 0.0, 0.0, 0));
  ASSERT_GE(lines.size(), 2U);
  const LineFeature& line = lines.front();
  // Too far away, of the other polarity, of another contrast, blank, and outside.
  EXPECT_FALSE(LocateSegment(Bar(5.0, 5.0, 0.0, 0), line, line.segment));
  EXPECT_FALSE(LocateSegment(Bar(5.0, 0.0, 0.0, 0, 10.0), line, line.segment));
  EXPECT_FALSE(LocateSegment(Bar(5.0, 0.0, 0.0, 0, 100.0), line, line.segment));
  EXPECT_FALSE(LocateSegment(cv::Mat(kSize, CV_8UC1, cv::Scalar(80)), line, line.segment));
  EXPECT_FALSE(LocateSegment(Bar(5.0, 0.0, 0.0, 0), line, Shifted(line.segment, 500.0)));
  EXPECT_FALSE(LocateSegment(Bar(5.0, 0.0, 0.0, 0), line, {{50.0, 50.0}, {50.0, 50.0}}));
}

TEST(SegmentTracker, TwoFifthsOfASegmentMayBeHidden) {
  const cv::Mat image = Bar(5.0, 0.0, 0.0, 0);
  const auto lines = Detected(image);
  ASSERT_GE(lines.size(), 2U);
  cv::Mat hidden = image.clone();
  hidden.rowRange(20, 60).setTo(80);
  // Only what is seen has the accuracy of a segment of its length.
  const auto seen = LocateSegment(hidden, lines.front(), lines.front().segment);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(std::min(seen->segment.p.y(), seen->segment.q.y()), 60.0, 3.0);
  EXPECT_NEAR(std::max(seen->segment.p.y(), seen->segment.q.y()),
              std::max(lines.front().segment.p.y(), lines.front().segment.q.y()), 1.5);
  hidden.rowRange(20, 100).setTo(80);
  EXPECT_FALSE(LocateSegment(hidden, lines.front(), lines.front().segment));
}

}  // namespace
}  // namespace plslam::vo
