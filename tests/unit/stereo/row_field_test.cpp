// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "core/features/feature_extractor.h"
#include "core/geometry/se3.h"
#include "tests/unit/features/texture.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/stereo/stereo_matcher.h"

namespace plslam::vo {
namespace {

const StereoCamera kSkewCamera{
    .f_px = 400.0, .cx_px = 320.0, .cy_px = 240.0, .baseline_m = 0.1, .width_px = 640, .height_px = 480};

SE3 SomeMotion() { return SE3::Exp((Vector6d() << 0.01, -0.02, 0.04, 0.01, 0.02, -0.015).finished()); }

TEST(PairSkew, NoneChangesNothing) {
  EXPECT_TRUE(PairSkew().is_zero());
  EXPECT_EQ(PairSkew().RowOffset_px({100.0, 50.0}, 7.0), 0.0);
  EXPECT_EQ(PairSkew().Disparity_px({100.0, 50.0}, 7.0), 7.0);
}

TEST(PairSkew, RowAndDepthMatchTheMovedCamera) {
  const SE3 T_late_c = SomeMotion();
  const PairSkew skew(kSkewCamera, T_late_c);
  for (const double depth_m : {1.0, 5.0, 80.0}) {
    for (const Eigen::Vector2d& px : {Eigen::Vector2d(30.0, 40.0), {320.0, 240.0}, {600.0, 400.0}}) {
      const double disparity_px = kSkewCamera.FocalBaseline() / depth_m;
      const Eigen::Vector3d late = T_late_c * kSkewCamera.Backproject({px.x(), px.y(), disparity_px});
      const Eigen::Vector2d right = kSkewCamera.Project(late - Eigen::Vector3d(kSkewCamera.baseline_m, 0.0, 0.0));
      const double measured_px = px.x() - right.x();
      EXPECT_NEAR(skew.RowOffset_px(px, measured_px), right.y() - px.y(), 1e-9);
      EXPECT_NEAR(skew.RowOffsetAt_px(px, disparity_px), right.y() - px.y(), 1e-9);
      ASSERT_TRUE(skew.Disparity_px(px, measured_px));
      EXPECT_NEAR(*skew.Disparity_px(px, measured_px), disparity_px, 1e-9);
      EXPECT_NEAR(skew.Measured_px(px, disparity_px), measured_px, 1e-9);
    }
  }
}

TEST(PairSkew, WithoutABaselineThereIsNoDepth) {
  const SE3 along(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  EXPECT_FALSE(PairSkew(kSkewCamera, along).Disparity_px({300.0, 200.0}, 5.0));
}

}  // namespace

namespace {

const StereoCamera kRowCamera{
    .f_px = 300.0, .cx_px = 160.0, .cy_px = 120.0, .baseline_m = 0.1, .width_px = 320, .height_px = 240};

RowField Constant(double px) { return {kRowCamera, px * RowField::Coefficients::Unit(0), {}}; }

TEST(RowField, TermsEqualTheFormula) {
  RowField::Coefficients c;
  c << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  const RowField field(kRowCamera, c, {});
  EXPECT_DOUBLE_EQ(field.Offset_px({160.0, 120.0}), 1.0);
  EXPECT_DOUBLE_EQ(field.Offset_px({320.0, 120.0}), 1.0 + 2.0 + 4.0);
  EXPECT_DOUBLE_EQ(field.Offset_px({160.0, 240.0}), 1.0 + 3.0 + 6.0);
  EXPECT_DOUBLE_EQ(field.Offset_px({0.0, 240.0}), 1.0 - 2.0 + 3.0 + 4.0 - 5.0 + 6.0);
}

TEST(RowField, WithoutCoefficientsNothingDiffers) {
  EXPECT_TRUE(RowField().is_zero());
  EXPECT_TRUE(RowField(kRowCamera, RowField::Coefficients::Zero(), {}).is_zero());
  EXPECT_EQ(RowField().Offset_px({17.0, 3.0}), 0.0);
  EXPECT_EQ(RowField().Disparity_px({17.0, 3.0}), 0.0);
}

// A right camera that rolls and pitches moves pixels as the camera model predicts; the field that is fitted to its rows
// predicts its columns.
TEST(RowField, DisparitiesFollowTheRotationFromRows) {
  const double f = kRowCamera.f_px;
  for (const Eigen::Vector2d& pitch_roll : {Eigen::Vector2d(-4e-3, 3e-3), {0.02, 0.0}, {0.0, -0.02}}) {
    RowField::Coefficients rows = RowField::Coefficients::Zero();
    rows(0) = f * pitch_roll(0);
    rows(1) = pitch_roll(1) * kRowCamera.cx_px;
    rows(5) = f * pitch_roll(0) * kRowCamera.cy_px * kRowCamera.cy_px / (f * f);
    const RowField field(kRowCamera, rows, {.pitch_rad = pitch_roll(0), .roll_rad = pitch_roll(1)});
    const Eigen::Matrix3d R = ExpSO3({-pitch_roll(0), 0.0, pitch_roll(1)}).toRotationMatrix();
    for (const Eigen::Vector2d& px : {Eigen::Vector2d(20.0, 30.0), {300.0, 60.0}, {100.0, 200.0}, {160.0, 120.0}}) {
      const Eigen::Vector3d ray((px.x() - kRowCamera.cx_px) / f, (px.y() - kRowCamera.cy_px) / f, 1.0);
      const Eigen::Vector2d turned = kRowCamera.Project(R * ray);
      const Eigen::Vector2d place(turned.x(), px.y());
      EXPECT_NEAR(field.Offset_px(place), turned.y() - px.y(), 0.04) << pitch_roll.transpose();
      EXPECT_NEAR(field.LeftRow_px(turned), px.y(), 0.04) << pitch_roll.transpose();
      EXPECT_NEAR(field.Disparity_px(place), px.x() - turned.x(), 0.01) << pitch_roll.transpose();
    }
  }
}

/// Numbers of points and lines with the right disparity.
struct DepthsFound {
  int points = 0;
  int lines = 0;
};

cv::Mat BarsAndTexture(double disparity_px, double row_px) {
  cv::Mat image =
      test::RenderTexture(320, 240, {.shift_x_px = disparity_px, .shift_y_px = -row_px, .gain = 0.4}, 9, 2.0);
  const int u = static_cast<int>(disparity_px);
  const int v = static_cast<int>(row_px);
  image(cv::Rect(60 - u, 40 + v, 14, 150)).setTo(230);
  image(cv::Rect(135 - u, 25 + v, 22, 140)).setTo(190);
  image(cv::Rect(230 - u, 60 + v, 9, 160)).setTo(15);
  return image;
}

/// Matches a pair whose right image is `row_px` lower.
DepthsFound MatchWithRows(double row_px, const RowField& rows) {
  FeatureExtractor extractor{FeatureOptions()};
  const cv::Mat left = BarsAndTexture(0.0, 0.0);
  const cv::Mat right = BarsAndTexture(10.0, row_px);
  const StereoFeatures found = MatchStereo(extractor.Extract(left), extractor.Extract(right), left, right, rows, {});
  DepthsFound right_ones;
  const auto is_right = [](double disparity_px) { return std::abs(disparity_px - 10.0) < 0.5; };
  for (const StereoPoint& p : found.points) right_ones.points += is_right(p.disparity_px) ? 1 : 0;
  for (const StereoLine& l : found.lines) {
    right_ones.lines += is_right(l.disparity_p_px) && is_right(l.disparity_q_px) ? 1 : 0;
  }
  return right_ones;
}

TEST(MatchStereo, KnownVerticalDisparityCostsNoDepths) {
  const DepthsFound even = MatchWithRows(0.0, RowField());
  const DepthsFound unknown = MatchWithRows(7.0, RowField());
  const DepthsFound known = MatchWithRows(7.0, Constant(7.0));
  EXPECT_GT(even.points, 100);
  EXPECT_GE(even.lines, 5);
  EXPECT_LT(unknown.points, even.points / 4);
  EXPECT_GT(known.points, 9 * even.points / 10);
  EXPECT_GE(known.lines, even.lines - 1);
}

TEST(MatchStereo, PatchesMeasureAnyVerticalDisparity) {
  FeatureExtractor extractor{FeatureOptions()};
  const cv::Mat left = BarsAndTexture(0.0, 0.0);
  const cv::Mat right = BarsAndTexture(10.0, 1.0);
  for (const double expected_px : {0.0, 0.6, 1.0}) {
    const StereoFeatures found =
        MatchStereo(extractor.Extract(left), extractor.Extract(right), left, right, Constant(expected_px), {});
    int n = 0;
    double sum_px = 0.0;
    for (const StereoPoint& point : found.points) {
      if (!point.HasDepth() || !(point.sigma_row_px >= 0.0 && point.sigma_row_px < 0.1)) continue;
      ++n;
      sum_px += point.row_offset_px;
    }
    EXPECT_NEAR(sum_px / n, 1.0, 0.03) << expected_px;
    EXPECT_GT(n, 50) << expected_px;
  }
}

}  // namespace
}  // namespace plslam::vo
