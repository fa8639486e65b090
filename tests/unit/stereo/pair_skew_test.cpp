// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/row_field.h"

#include <gtest/gtest.h>

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

TEST(PairSkew, RowAndDepthAreThoseOfTheMovedCamera) {
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
    }
  }
}

TEST(PairSkew, WithoutABaselineThereIsNoDepth) {
  const SE3 along(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  EXPECT_FALSE(PairSkew(kSkewCamera, along).Disparity_px({300.0, 200.0}, 5.0));
}

}  // namespace
}  // namespace plslam::vo
