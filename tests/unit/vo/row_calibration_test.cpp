// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/row_calibration.h"

#include <gtest/gtest.h>

#include <random>

#include "core/datasets/open_dataset.h"
#include "tests/support/odometry_run.h"
#include "tests/unit/vo/bent_rig.h"

namespace plslam::vo {
namespace {

const StereoCamera kRowRig{
    .f_px = 400.0, .cx_px = 320.0, .cy_px = 240.0, .baseline_m = 0.1, .width_px = 640, .height_px = 480};

RowField::Coefficients SomeRows() {
  RowField::Coefficients rows;
  rows << -0.3, 0.2, 0.1, -0.3, 1.2, 0.1;
  return rows;
}

/// Returns matches all over the image whose rows are those of `rows`, up to noise; every eighth is wrong.
StereoFeatures MatchesWithRows(const RowField& rows, double sigma_px, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  StereoFeatures features;
  for (int i = 0; i < 200; ++i) {
    StereoPoint point;
    point.left.px = {639.0 * uniform(random), 479.0 * uniform(random)};
    point.disparity_px = 1.0 + 60.0 * uniform(random);
    point.sigma_row_px = sigma_px;
    point.row_offset_px =
        rows.Offset_px(point.left.px - Eigen::Vector2d(point.disparity_px, 0.0)) + sigma_px * normal(random);
    if (i % 8 == 0) point.row_offset_px += 6.0 * uniform(random) - 3.0;
    features.points.push_back(point);
  }
  return features;
}

RowField Learned(const RowField& truth, int n_frames, const RowCalibrationOptions& options = {}) {
  RowCalibration calibration(kRowRig, options);
  std::mt19937 random(5);
  for (int i = 0; i < n_frames; ++i) calibration.Observe(MatchesWithRows(truth, 0.1, random));
  return calibration.field();
}

TEST(RowCalibration, FindsVerticalDisparityDespiteOutliers) {
  const RowField truth(kRowRig, SomeRows(), {});
  const RowField found = Learned(truth, 10);
  for (const Eigen::Vector2d& px :
       {Eigen::Vector2d(0.0, 0.0), {639.0, 0.0}, {0.0, 479.0}, {639.0, 479.0}, {320.0, 240.0}}) {
    EXPECT_NEAR(found.Offset_px(px), truth.Offset_px(px), 0.1);
  }
}

TEST(RowCalibration, OneFrameIsEnoughForLargeErrors) {
  EXPECT_NEAR(Learned({kRowRig, SomeRows(), {}}, 1).Offset_px({639.0, 479.0}), 1.0, 0.25);
}

TEST(RowCalibration, GoodRigsAreLeftAlone) {
  EXPECT_TRUE(Learned(RowField(), 50).is_zero());
  EXPECT_TRUE(Learned({kRowRig, 0.2 * SomeRows(), {}}, 50).is_zero()) << "too little to matter";
}

TEST(RowCalibration, DisabledItLearnsNothing) {
  EXPECT_TRUE(Learned({kRowRig, SomeRows(), {}}, 10, {.enabled = false}).is_zero());
}

TEST(RowCalibration, MatchesWithUncertainRowsAreNotUsed) {
  RowCalibration calibration(kRowRig, {});
  std::mt19937 random(5);
  for (int i = 0; i < 10; ++i) {
    StereoFeatures features = MatchesWithRows({kRowRig, SomeRows(), {}}, 0.1, random);
    for (size_t k = 0; k < features.points.size(); ++k) {
      StereoPoint& point = features.points[k];
      if (k % 3 == 0) point.disparity_px = -1.0;
      if (k % 3 == 1) point.sigma_row_px = -1.0;
      if (k % 3 == 2) point.sigma_row_px = 0.8;
    }
    calibration.Observe(features);
  }
  calibration.Observe({});
  EXPECT_TRUE(calibration.field().is_zero());
}

StereoFeatures Some(const StereoFeatures& features, size_t n) {
  return {{features.points.begin(), features.points.begin() + static_cast<std::ptrdiff_t>(n)}, {}, {}};
}

TEST(RowCalibration, FewMatchesAreCheckedPeriodically) {
  const RowField truth(kRowRig, 4.0 * RowField::Coefficients::Unit(0), {});
  RowCalibration calibration(kRowRig, {});
  std::mt19937 random(5);
  int n_looks = 0;
  for (int i = 0; i < 100; ++i) {
    n_looks += calibration.needs_look() ? 1 : 0;
    EXPECT_FALSE(calibration.Observe(Some(MatchesWithRows(truth, 0.1, random), i % 20)));
  }
  EXPECT_EQ(n_looks, 10 + 3);
  EXPECT_TRUE(calibration.Observe(MatchesWithRows(truth, 0.1, random)));
  EXPECT_FALSE(calibration.needs_look());
  EXPECT_NEAR(calibration.field().Offset_px({100.0, 400.0}), 4.0, 0.2);
}

TEST(RowCalibration, DarknessChangesNothing) {
  RowCalibration calibration(kRowRig, {});
  std::mt19937 random(5);
  calibration.Observe(MatchesWithRows({kRowRig, 0.7 * SomeRows(), {}}, 0.1, random));
  const double before_px = calibration.field().Offset_px({639.0, 479.0});
  EXPECT_NE(before_px, 0.0);
  for (int i = 0; i < 5000; ++i) EXPECT_FALSE(calibration.Observe({}));
  EXPECT_EQ(calibration.field().Offset_px({639.0, 479.0}), before_px);
}

// A correction close to the threshold does not switch on and off all the time.
TEST(RowCalibration, DoesNotFlicker) {
  for (const double norm_px : {0.40, 0.45, 0.50, 0.55, 0.60}) {
    RowCalibration calibration(kRowRig, {});
    std::mt19937 random(7);
    const RowField truth(kRowRig, norm_px / SomeRows().norm() * SomeRows(), {});
    int changes = 0;
    for (int i = 0; i < 500; ++i) changes += calibration.Observe(MatchesWithRows(truth, 0.1, random)) ? 1 : 0;
    EXPECT_LE(changes, 2) << norm_px;
  }
}

/// Returns the disparity at a position, by the rotation that rows of this type imply.
double TurnedDisparity(double r0_px, double r5_px) {
  RowField::Coefficients rows = RowField::Coefficients::Zero();
  rows(0) = r0_px;
  rows(5) = r5_px;
  return Learned({kRowRig, rows, {}}, 20).Disparity_px({600.0, 450.0});
}

// Rows that are all lower by as much may be a pitch, or an image that was cut otherwise; a pitch bends them, too.
TEST(RowCalibration, PitchIsUsedAsFarAsItBendsTheRows) {
  const double bend = 240.0 * 240.0 / (400.0 * 400.0);
  const double pitch_rad = 4.0 / 400.0;
  const double turned_px = std::abs(pitch_rad * (600.0 - 320.0) * (450.0 - 240.0) / 400.0);
  EXPECT_NEAR(std::abs(TurnedDisparity(4.0, 4.0 * bend)), turned_px, 0.1 * turned_px);
  EXPECT_LT(std::abs(TurnedDisparity(4.0, 0.0)), 0.7 * turned_px);
}

double ErrorOf(const Dataset& dataset, bool follows_rows) {
  VoOptions options;
  options.row_calibration.enabled = follows_rows;
  return test::AbsoluteTrajectoryError(test::RunOdometry(dataset, options));
}

// A roll of 10 mrad and a pitch of 5: rows differ by up to 3 pixels here. Or a pitch of 15, 4 pixels.
TEST(RowCalibration, BentRigsAreFollowed) {
  const auto straight = OpenDataset("synthetic:room?size=376x240&rate=10&frames=60", "");
  const double straight_m = ErrorOf(*straight, true);
  EXPECT_EQ(ErrorOf(*straight, false), straight_m) << "a good rig is left alone";
  for (const Eigen::Vector3d& turn_rad : {Eigen::Vector3d(-0.005, 0.0, 0.01), Eigen::Vector3d(0.015, 0.0, 0.0)}) {
    const test::BentRig bent(*straight, turn_rad);
    const double followed_m = ErrorOf(bent, true);
    EXPECT_LT(followed_m, 1.6 * straight_m) << turn_rad.transpose();
    EXPECT_GT(ErrorOf(bent, false), 5.0 * followed_m) << turn_rad.transpose();
  }
}

}  // namespace
}  // namespace plslam::vo
