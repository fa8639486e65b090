// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/plot.h"

#include <gtest/gtest.h>

#include "tests/unit/evaluate/pairs.h"
#include "tools/evaluate/chart.h"

namespace plslam {
namespace {

int CountColour(const cv::Mat& picture, const cv::Vec3b& colour) {
  int n = 0;
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) n += picture.at<cv::Vec3b>(row, column) == colour ? 1 : 0;
  }
  return n;
}

TEST(Plot, MarksAreOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(MarkDistance(10.0, 11), 1.0);
  EXPECT_DOUBLE_EQ(MarkDistance(10.0, 6), 2.0);
  EXPECT_DOUBLE_EQ(MarkDistance(10.0, 4), 5.0);
  EXPECT_DOUBLE_EQ(MarkDistance(0.03, 4), 0.01);
  EXPECT_NEAR(MarkDistance(7e8, 8), 1e8, 1.0);
}

TEST(Plot, ShowsBothPathsAndTheErrors) {
  const Trajectory truth = SomePath(100);
  const Trajectory estimate = WithDrift(truth, SE3::Exp((Vector6d() << 0, 0, 0.1, 0, 0.01, 0).finished()));
  const cv::Mat picture = PlotAccuracy(EvaluateTrajectory(estimate, truth, {}), "title");
  EXPECT_EQ(picture.size(), cv::Size(1000, 1220));
  EXPECT_GT(CountColour(picture, {110, 110, 110}), 300) << "truth";
  EXPECT_GT(CountColour(picture, {190, 90, 20}), 300) << "estimate";
  EXPECT_GT(CountColour(picture, {50, 60, 200}), 300) << "errors";
}

TEST(Plot, NothingOnePoseAndStandingStillAreDrawn) {
  const Trajectory still{{0, SE3()}, {1, SE3()}};
  for (const Trajectory& path : {Trajectory{}, SomePath(1), still}) {
    EXPECT_FALSE(PlotAccuracy(EvaluateTrajectory(path, path, {}), "title").empty());
  }
}

TEST(Plot, EstimateFarAwayDoesNotOverflow) {
  Trajectory estimate = SomePath(3);
  estimate[1].T_a_b = Translation(1e15, -1e15, 0);
  EvaluateOptions options;
  options.alignment = Alignment::kNone;
  EXPECT_FALSE(PlotAccuracy(EvaluateTrajectory(estimate, SomePath(3), options), "title").empty());
}

}  // namespace
}  // namespace plslam
