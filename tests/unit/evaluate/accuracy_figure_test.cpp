// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/figures/accuracy_figure.h"

#include <gmock/gmock.h>

#include "tests/unit/evaluate/drawn_texts.h"
#include "tests/unit/evaluate/pairs.h"

namespace plslam::evaluate {
namespace {

using test::DrawnTexts;
using testing::Contains;

int CountColour(const cv::Mat& picture, const cv::Vec3b& colour) {
  int n = 0;
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) n += picture.at<cv::Vec3b>(row, column) == colour ? 1 : 0;
  }
  return n;
}

TEST(AccuracyFigure, ShowsBothPathsAndTheErrors) {
  const Trajectory truth = SomePath(100);
  const Trajectory estimate = WithDrift(truth, SE3::Exp((Vector6d() << 0, 0, 0.1, 0, 0.01, 0).finished()));
  const Drawing drawing = AccuracyFigure("title", EvaluateTrajectory(estimate, truth, {}));
  for (const char* text : {"title", "truth", "estimate (o start)", "position error", "orientation error", "[deg]"}) {
    EXPECT_THAT(DrawnTexts(drawing), Contains(text));
  }
  const cv::Mat picture = ToPicture(drawing, 300.0);
  EXPECT_EQ(picture.cols, 1050) << "a column";
  EXPECT_GT(CountColour(picture, {110, 110, 110}), 300) << "truth";
  EXPECT_GT(CountColour(picture, {180, 80, 31}), 300) << "estimate";
  EXPECT_GT(CountColour(picture, {40, 39, 214}), 300) << "errors";
}

TEST(AccuracyFigure, NothingOnePoseAndStandingStillAreDrawn) {
  const Trajectory still{{0, SE3()}, {1, SE3()}};
  for (const Trajectory& path : {Trajectory{}, SomePath(1), still}) {
    EXPECT_FALSE(ToPicture(AccuracyFigure("title", EvaluateTrajectory(path, path, {}))).empty());
  }
  EXPECT_THAT(DrawnTexts(AccuracyFigure("title", EvaluateTrajectory({}, {}, {}))),
              Contains("the estimate has no pose"));
}

TEST(AccuracyFigure, EstimateFarAwayDoesNotOverflow) {
  Trajectory estimate = SomePath(3);
  estimate[1].T_a_b = Translation(1e15, -1e15, 0);
  EvaluateOptions options;
  options.alignment = Alignment::kNone;
  EXPECT_FALSE(ToPicture(AccuracyFigure("title", EvaluateTrajectory(estimate, SomePath(3), options))).empty());
}

}  // namespace
}  // namespace plslam::evaluate
