#include "vo_process/tracking/disparity_calibration.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/support/feature_world.h"
#include "vo_process/tracking/odometry.h"

namespace plslam {
namespace {

using test::FeatureWorld;

constexpr int64_t kDriveFrame_ns = 100'000'000;
constexpr double kNoise_px = 0.3;

// Forwards and a little sideways through the shell of landmarks.
SE3 DrivenPoseAt(int frame) {
  return SE3(ExpSO3(Eigen::Vector3d(0.0, 0.01 * frame, 0.0)), Eigen::Vector3d(0.02 * frame, 0.0, 0.05 * frame - 2.0));
}

// Odometry over 60 frames whose disparities are wrong by `error_px` of the column.
Odometry Drive(const std::function<double(double)>& error_px, bool enabled) {
  const FeatureWorld world({400, 60}, 11);
  VoOptions options;
  options.disparity_calibration.enabled = enabled;
  Odometry odometry(FeatureWorld::Camera(), options);
  for (int i = 0; i < 60; ++i) {
    StereoFeatures features = world.Observe(DrivenPoseAt(i), kNoise_px, static_cast<uint64_t>(i));
    for (StereoPoint& point : features.points) point.disparity_px += error_px(point.left.px.x());
    for (StereoLine& line : features.lines) {
      if (!line.HasDepth()) continue;
      line.disparity_p_px += error_px(line.left.segment.p.x());
      line.disparity_q_px += error_px(line.left.segment.q.x());
    }
    odometry.Track(i * kDriveFrame_ns, std::move(features));
  }
  return odometry;
}

double Offset(const Odometry& odometry, double u_px) { return odometry.disparity_calibration().Offset_px(u_px); }

TEST(DisparityCalibration, PerfectRigIsLeftAlone) {
  const Odometry odometry = Drive([](double) { return 0.0; }, true);
  for (const double u_px : {0.0, 320.0, 639.0}) EXPECT_EQ(Offset(odometry, u_px), 0.0);
}

TEST(DisparityCalibration, ConstantOffsetIsFound) {
  const Odometry odometry = Drive([](double) { return -0.4; }, true);
  EXPECT_NEAR(Offset(odometry, 320.0), -0.4, 0.15);
}

TEST(DisparityCalibration, SquareOffsetIsFound) {
  const auto error_px = [](double u_px) { return 1.0 * (u_px - 320.0) * (u_px - 320.0) / (400.0 * 400.0); };
  const Odometry odometry = Drive(error_px, true);
  EXPECT_NEAR(Offset(odometry, 600.0) - Offset(odometry, 320.0), error_px(600.0), 0.25);
}

TEST(DisparityCalibration, SwitchedOffItChangesNothing) {
  const Odometry odometry = Drive([](double) { return -0.4; }, false);
  EXPECT_EQ(Offset(odometry, 320.0), 0.0);
}

TEST(DisparityCalibration, CorrectionThatLeavesNoDisparityTakesTheDepth) {
  const Odometry odometry = Drive([](double) { return 0.4; }, true);
  DisparityCalibration calibration = odometry.disparity_calibration();
  StereoFeatures features;
  features.points.resize(3);
  for (StereoPoint& point : features.points) point.left.px = {320.0, 240.0};
  features.points[0].disparity_px = 5.0;
  features.points[1].disparity_px = 0.1;
  calibration.Correct(features);
  EXPECT_NEAR(features.points[0].disparity_px, 4.6, 0.15);
  EXPECT_FALSE(features.points[1].HasDepth()) << "nothing is left of it";
  EXPECT_FALSE(features.points[2].HasDepth()) << "it never had one";
}

TEST(DisparityCalibration, StandingCameraLearnsNothing) {
  const FeatureWorld world({400, 60}, 11);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 60; ++i) {
    StereoFeatures features = world.Observe(DrivenPoseAt(0), kNoise_px, static_cast<uint64_t>(i));
    for (StereoPoint& point : features.points) point.disparity_px -= 0.4;
    odometry.Track(i * kDriveFrame_ns, std::move(features));
  }
  EXPECT_EQ(Offset(odometry, 320.0), 0.0);
}

}  // namespace
}  // namespace plslam
