// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/row_offsets.h"

#include <gtest/gtest.h>

#include <random>

#include <opencv2/imgproc.hpp>

#include "core/datasets/synthetic/simulator.h"
#include "core/geometry/rectifier.h"
#include "dense_process/depth.h"
#include "vo_process/options.h"
#include "vo_process/stereo/stereo_front_end.h"

namespace plslam::dense {
namespace {

/// Points anywhere in the image whose rows are off by `field(x, y)`, in half image sizes, with noise and outliers.
template <class Field>
StereoFeatures Points(int n, const Field& field) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> noise_px(0.0, 0.2);
  StereoFeatures features;
  for (int i = 0; i < n; ++i) {
    StereoPoint& point = features.points.emplace_back();
    point.left.px = {752.0 * uniform(random), 480.0 * uniform(random)};
    point.disparity_px = 10.0;
    point.sigma_row_px = 0.2;
    const double x = (point.left.px.x() - 10.0 - 376.0) / 376.0, y = (point.left.px.y() - 240.0) / 240.0;
    point.row_offset_px = field(x, y) + noise_px(random) + (i % 10 == 0 ? 4.0 * uniform(random) : 0.0);
  }
  return features;
}

class RowOffsetsTest : public testing::Test {
 protected:
  static constexpr StereoCamera kCamera{
      .f_px = 450.0, .cx_px = 376.0, .cy_px = 240.0, .baseline_m = 0.11, .width_px = 752, .height_px = 480};
};

TEST_F(RowOffsetsTest, OffsetAndTurnAreMeasured) {
  const RowOffsets shifted = EstimateRows(Points(400, [](double, double) { return 1.0; }), kCamera);
  EXPECT_NEAR(shifted.size_px, 1.0, 0.05);
  EXPECT_LT(shifted.sigma_px, 0.05);
  EXPECT_NEAR(shifted.At(kCamera, 700.0, 20.0), 1.0, 0.2);
  const RowOffsets turned = EstimateRows(Points(400, [](double x, double) { return 2.0 * x; }), kCamera);
  EXPECT_NEAR(turned.size_px, 2.0 / std::sqrt(3.0), 0.1) << "zero in the mean";
  EXPECT_NEAR(turned.At(kCamera, 752.0, 240.0), 2.0, 0.2);
}

TEST_F(RowOffsetsTest, GoodPairsHaveNone) {
  EXPECT_TRUE(EstimateRows(Points(400, [](double, double) { return 0.1; }), kCamera).is_zero());
  EXPECT_TRUE(EstimateRows(Points(40, [](double, double) { return 3.0; }), kCamera).is_zero()) << "too few";
  EXPECT_TRUE(EstimateRows({}, kCamera).is_zero());
}

/// Pairs of the built-in room whose right image has moved.
class RoomRows : public testing::Test {
 protected:
  DepthImage Match(const cv::Matx23d& motion, bool knows_rows = true) {
    StereoImages images = simulator_.Render(0);
    cv::warpAffine(images.right, images.right, motion, images.right.size());
    vo::StereoFrontEnd front_end(simulator_.rig(), {});
    vo::StageTimer timer([] { return 0.0; });
    StereoFeatures features = front_end.Process(images, timer);
    if (!knows_rows) {
      for (StereoPoint& point : features.points) point.sigma_row_px = -1.0;
    }
    return MatchPair(images.left, images.right, {}, rectifier_.camera(), features);
  }
  static int Known(const DepthImage& depth) { return cv::countNonZero(depth.z_m); }
  static cv::Matx23d Shift(double rows) { return {1, 0, 0, 0, 1, rows}; }

  const synthetic::Simulator simulator_{synthetic::ParseOptions("room")};
  const Rectifier rectifier_{simulator_.rig()};
};

TEST_F(RoomRows, SmallOffsetIsCorrectedAndMeasured) {
  const DepthImage good = Match(Shift(0.0));
  EXPECT_TRUE(good.rows.is_zero()) << good.rows.size_px;
  EXPECT_GT(good.agreement, 0.95);
  for (const double rows_px : {-1.0, 1.0}) {
    const DepthImage off = Match(Shift(rows_px));
    EXPECT_NEAR(off.rows.size_px, 1.0, 0.1);
    EXPECT_LT(off.rows.sigma_px, 0.05);
    EXPECT_NEAR(off.rows.At(rectifier_.camera(), 300.0, 200.0), rows_px, 0.15);
    const DepthImage uncorrected = Match(Shift(rows_px), false);
    printf("%+.0f px: %.2f px (sigma %.3f); known pixels %d, %d uncorrected, %d without an offset\n", rows_px,
           off.rows.size_px, off.rows.sigma_px, Known(off), Known(uncorrected), Known(good));
    EXPECT_GT(off.agreement, 0.95);
    EXPECT_GT(Known(off), 0.97 * Known(good));
  }
}

TEST_F(RoomRows, LargeOffsetDisagrees) { EXPECT_LT(Match(Shift(8.0)).agreement, 0.6); }

}  // namespace
}  // namespace plslam::dense
