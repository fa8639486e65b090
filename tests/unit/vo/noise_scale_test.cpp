// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "vo_process/tracking/calibration/noise_scale.h"

namespace plslam::vo {
namespace {

constexpr int kManyFrames = 200;

// Returns a frame whose points, before any scale, have `ratio` times the residuals of its lines.
Alignment Frame(double ratio, size_t n_points = 100, size_t n_lines = 50) {
  Alignment alignment;
  alignment.matches.points.resize(n_points);
  alignment.matches.lines.resize(n_lines);
  alignment.point_deviation = 0.8 * ratio;
  alignment.line_deviation = 0.8;
  return alignment;
}

// Sigmas of points shrink as their sigmas grow.
double ScaleAfter(NoiseScale& balance, double ratio, int n_frames) {
  for (int i = 0; i < n_frames; ++i) balance.Observe(Frame(ratio / balance.scale()));
  return balance.scale();
}

TEST(NoiseScale, GrowsByMoreThanTheResidualsShow) {
  NoiseScale balance(4.0);
  const double early = ScaleAfter(balance, 2.0, 3);
  EXPECT_GT(early, 1.2);
  EXPECT_LT(early, 1.8);
  // A tenth is allowed; the rest counts with the power of 1.5.
  EXPECT_NEAR(ScaleAfter(balance, 2.0, kManyFrames), 2.45, 0.02);
}

TEST(NoiseScale, UnchangedByChance) {
  NoiseScale balance(4.0);
  EXPECT_EQ(ScaleAfter(balance, 1.09, kManyFrames), 1.0);
}

TEST(NoiseScale, StaysWithinItsBounds) {
  NoiseScale balance(2.0);
  EXPECT_EQ(ScaleAfter(balance, 9.0, kManyFrames), 2.0);
  EXPECT_EQ(ScaleAfter(balance, 0.4, kManyFrames), 1.0);
  NoiseScale off(1.0);
  EXPECT_EQ(ScaleAfter(off, 9.0, kManyFrames), 1.0);
}

TEST(NoiseScale, DecaysWithoutEvidence) {
  NoiseScale balance(16.0);
  const double learned = ScaleAfter(balance, 9.0, kManyFrames);
  ASSERT_GT(learned, 8.0);
  balance.Observe(Frame(1.0, 100, 5));
  EXPECT_GT(balance.scale(), 0.8 * learned);
  for (int i = 0; i < kManyFrames; ++i) balance.Observe(Frame(1.0, 100, 5));
  EXPECT_NEAR(balance.scale(), 1.0, 1e-3);
}

TEST(NoiseScale, LearnsNothingFromFewOrInvalidResiduals) {
  NoiseScale balance(4.0);
  Alignment frame = Frame(3.0, 5, 50);
  balance.Observe(frame);
  balance.Observe(Frame(3.0, 100, 5));
  frame = Frame(3.0);
  for (const double nonsense :
       {0.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    frame.line_deviation = nonsense;
    balance.Observe(frame);
  }
  EXPECT_EQ(balance.scale(), 1.0);
}

TEST(NoiseScale, MultipliesSigmasOfPointsOnly) {
  NoiseScale balance(4.0);
  ScaleAfter(balance, 2.0, kManyFrames);
  StereoFeatures features;
  features.points.resize(2);
  features.lines.resize(1);
  features.points[1].sigma_px = 0.5;
  features.points[1].sigma_disparity_px = 0.25;
  balance.Apply(features);
  EXPECT_DOUBLE_EQ(features.points[1].sigma_px, 0.5 * balance.scale());
  EXPECT_DOUBLE_EQ(features.points[1].sigma_disparity_px, 0.25 * balance.scale());
  EXPECT_EQ(features.lines[0].sigma_px, 1.0);
}

}  // namespace

namespace {

StereoFeatures OneLine(const Segment2& segment) {
  StereoFeatures features;
  features.lines.resize(1);
  StereoLine& line = features.lines.front();
  line.left.segment = segment;
  line.sigma_px = 0.3;
  line.sigma_disparity_p_px = line.sigma_disparity_q_px = 0.5;
  return features;
}

TEST(AddLineModelError, AddsInSquares) {
  StereoFeatures features = OneLine({{100.0, 100.0}, {100.0, 200.0}});
  AddLineModelError(0.4, features);
  EXPECT_NEAR(features.lines[0].sigma_px, 0.5, 1e-12);
  EXPECT_NEAR(features.lines[0].sigma_disparity_p_px, std::sqrt(0.25 + 2.0 * 0.16), 1e-12);
}

TEST(AddLineModelError, CountsMoreAlongTheRowForFlatLines) {
  StereoFeatures steep = OneLine({{100.0, 100.0}, {110.0, 200.0}});
  StereoFeatures flat = OneLine({{100.0, 100.0}, {200.0, 120.0}});
  AddLineModelError(0.4, steep);
  AddLineModelError(0.4, flat);
  EXPECT_GT(flat.lines[0].sigma_disparity_q_px, 3.0 * steep.lines[0].sigma_disparity_q_px);
}

TEST(AddLineModelError, HorizontalLineStaysFinite) {
  StereoFeatures features = OneLine({{100.0, 100.0}, {200.0, 100.0}});
  AddLineModelError(0.4, features);
  EXPECT_TRUE(std::isfinite(features.lines[0].sigma_disparity_p_px));
}

}  // namespace
}  // namespace plslam::vo
