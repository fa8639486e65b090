// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/lines/rendered_edges.h"
#include "vo_process/stereo/line_stereo.h"

namespace plslam::vo {
namespace {

constexpr double kUnits = 5000.0;
const StereoCamera kDepthCamera{500.0, 160.0, 120.0, 0.08, 320, 240};

/// Depth of the plane 1/Z = inverse + slope * u.
cv::Mat Plane(double inverse, double slope, double noise) {
  const cv::Mat random = test::NoiseImage({320, 240}, 128, 30, 6);
  cv::Mat depth(240, 320, CV_16UC1);
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      const double w = inverse + slope * x + noise * (random.at<uint8_t>(y, x) - 128) / 30.0;
      depth.at<uint16_t>(y, x) = cv::saturate_cast<uint16_t>(kUnits / w);
    }
  }
  return depth;
}

std::vector<StereoLine> OneLine(const Segment2& segment) {
  LineFeature f;
  f.segment = segment;
  f.response = 30;
  return WithoutDepth({f});
}

const Segment2 kSegment{{60, 100}, {240, 130}};

TEST(LineDepth, PlaneGivesExactVirtualDisparities) {
  auto lines = OneLine(kSegment);
  AttachDepthToLines(lines, Plane(0.4, 0.001, 0.0), kUnits, kDepthCamera, StereoOptions());
  ASSERT_TRUE(lines[0].HasDepth());
  EXPECT_NEAR(lines[0].disparity_p_px, 40.0 * (0.4 + 0.001 * 60), 0.01);
  EXPECT_NEAR(lines[0].disparity_q_px, 40.0 * (0.4 + 0.001 * 240), 0.01);
}

TEST(LineDepth, ParallelToTheBaselineHasItsDepth) {
  auto lines = OneLine({{60, 100}, {240, 100}});
  AttachDepthToLines(lines, Plane(0.5, 0.0, 0.0), kUnits, kDepthCamera, StereoOptions());
  ASSERT_TRUE(lines[0].HasDepth());
  EXPECT_NEAR(lines[0].disparity_p_px, 20.0, 0.01);
}

TEST(LineDepth, SigmaFollowsTheSensorNoise) {
  double last = 0.0;
  for (const double noise : {0.0005, 0.002, 0.01}) {
    StereoOptions options;
    options.depth_noise_per_m = noise;
    auto lines = OneLine(kSegment);
    AttachDepthToLines(lines, Plane(0.4, 0.0, 0.0), kUnits, kDepthCamera, options);
    ASSERT_TRUE(lines[0].HasDepth());
    EXPECT_GT(lines[0].sigma_disparity_p_px, 0.4 * 40.0 * noise);
    EXPECT_LT(lines[0].sigma_disparity_p_px, 40.0 * noise);
    EXPECT_GT(lines[0].sigma_disparity_p_px, 3.0 * last);
    last = lines[0].sigma_disparity_p_px;
  }
}

TEST(LineDepth, NoiseAndHolesStayWithinTheSigma) {
  cv::Mat depth = Plane(0.5, 0.0005, 0.0015);
  for (int x = 60; x < 240; x += 7) depth.colRange(x, x + 2).setTo(0);
  depth.colRange(150, 156).setTo(600);  // something in front of a few samples
  auto lines = OneLine(kSegment);
  AttachDepthToLines(lines, depth, kUnits, kDepthCamera, StereoOptions());
  ASSERT_TRUE(lines[0].HasDepth());
  EXPECT_NEAR(lines[0].disparity_p_px, 40.0 * 0.53, 3.0 * lines[0].sigma_disparity_p_px);
  EXPECT_NEAR(lines[0].disparity_q_px, 40.0 * 0.62, 3.0 * lines[0].sigma_disparity_q_px);
  EXPECT_LT(lines[0].sigma_disparity_p_px, 0.1);
}

TEST(LineDepth, EdgeOfAnObjectBelongsToTheObject) {
  cv::Mat depth = Plane(0.25, 0.0, 0.0);
  depth.colRange(100, 320).setTo(kUnits / 1.0);  // 1 m in front of 4 m, from column 100
  auto lines = OneLine({{99.4, 40}, {99.4, 200}});
  AttachDepthToLines(lines, depth, kUnits, kDepthCamera, StereoOptions());
  ASSERT_TRUE(lines[0].HasDepth());
  EXPECT_NEAR(lines[0].disparity_p_px, 40.0, 0.1);
}

TEST(LineDepth, BreakAcrossTheSegmentGivesNone) {
  cv::Mat depth = Plane(0.25, 0.0, 0.0);
  depth.colRange(150, 320).setTo(kUnits / 1.0);
  auto lines = OneLine(kSegment);
  AttachDepthToLines(lines, depth, kUnits, kDepthCamera, StereoOptions());
  EXPECT_FALSE(lines[0].HasDepth());
}

TEST(LineDepth, UnknownDepthsGiveNone) {
  auto lines = OneLine(kSegment);
  cv::Mat depth(240, 320, CV_16UC1, cv::Scalar(0));
  AttachDepthToLines(lines, depth, kUnits, kDepthCamera, StereoOptions());
  EXPECT_FALSE(lines[0].HasDepth());
  depth.colRange(60, 120).setTo(5000);  // a third of the segment
  AttachDepthToLines(lines, depth, kUnits, kDepthCamera, StereoOptions());
  EXPECT_FALSE(lines[0].HasDepth());
  AttachDepthToLines(lines, cv::Mat(), kUnits, kDepthCamera, StereoOptions());
  EXPECT_FALSE(lines[0].HasDepth());
}

TEST(LineDepth, SegmentsOutsideOrNotFiniteGiveNone) {
  for (const Segment2& s :
       {Segment2{{-500, -500}, {-400, -400}}, Segment2{{NAN, 1}, {2, 3}}, Segment2{{5, 5}, {5, 5}}}) {
    auto lines = OneLine(s);
    AttachDepthToLines(lines, Plane(0.5, 0.0, 0.0), kUnits, kDepthCamera, StereoOptions());
    EXPECT_FALSE(lines[0].HasDepth());
  }
  std::vector<StereoLine> none;
  AttachDepthToLines(none, Plane(0.5, 0.0, 0.0), kUnits, kDepthCamera, StereoOptions());
}

}  // namespace
}  // namespace plslam::vo
