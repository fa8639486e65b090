// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/noise_scale.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plslam::vo {
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
