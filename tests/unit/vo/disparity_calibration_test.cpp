// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/disparity_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/datasets/open_dataset.h"
#include "core/files/archive.h"
#include "tests/support/feature_world.h"
#include "tests/support/steady_ms.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

using test::FeatureWorld;

constexpr int64_t kDriveFrame_ns = 100'000'000;
constexpr double kNoise_px = 0.3;

// Forwards and a little sideways through the shell of landmarks.
SE3 DrivenPoseAt(int frame) {
  return SE3(ExpSO3(Eigen::Vector3d(0.0, 0.01 * frame, 0.0)), Eigen::Vector3d(0.02 * frame, 0.0, 0.05 * frame - 2.0));
}

// By column and disparity.
using Error = std::function<double(double u_px, double disparity_px)>;

StereoFeatures WithError(StereoFeatures features, const Error& error_px) {
  for (StereoPoint& point : features.points) {
    point.disparity_px += error_px(point.left.px.x(), point.disparity_px);
    point.sigma_row_px = kNoise_px;  // it is of a match
  }
  for (StereoLine& line : features.lines) {
    if (!line.HasDepth()) continue;
    line.disparity_p_px += error_px(line.left.segment.p.x(), line.disparity_p_px);
    line.disparity_q_px += error_px(line.left.segment.q.x(), line.disparity_q_px);
  }
  return features;
}

void DriveOn(int first, int end, const Error& error_px, Odometry& odometry) {
  const FeatureWorld world({400, 60}, 11);
  for (int i = first; i < end; ++i) {
    StereoFeatures features = world.Observe(DrivenPoseAt(i), kNoise_px, static_cast<uint64_t>(i));
    odometry.Track(i * kDriveFrame_ns, WithError(std::move(features), error_px));
  }
}

// Runs odometry over frames with wrong disparities.
Odometry Drive(const Error& error_px, bool enabled = true, int n_frames = 60) {
  VoOptions options;
  options.disparity_calibration.enabled = enabled;
  Odometry odometry(FeatureWorld::Camera(), options);
  DriveOn(0, n_frames, error_px, odometry);
  return odometry;
}

// Returns the median of the true disparities in the frames of a drive.
double MedianDisparity_px(int n_frames) {
  const FeatureWorld world({400, 60}, 11);
  std::vector<double> disparities_px;
  for (int i = 0; i < n_frames; ++i) {
    for (const StereoPoint& point : world.Observe(DrivenPoseAt(i), 0.0, static_cast<uint64_t>(i)).points) {
      if (point.HasDepth()) disparities_px.push_back(point.disparity_px);
    }
  }
  std::ranges::nth_element(disparities_px, disparities_px.begin() + disparities_px.size() / 2);
  return disparities_px[disparities_px.size() / 2];
}

double Offset(const Odometry& odometry, double u_px) { return odometry.calibration().disparities().Offset_px(u_px); }

double Nothing(double, double) { return 0.0; }
double Constant(double, double) { return -0.4; }

TEST(DisparityCalibration, PerfectRigIsLeftAlone) {
  const Odometry odometry = Drive(Nothing);
  for (const double u_px : {0.0, 320.0, 639.0}) EXPECT_EQ(Offset(odometry, u_px), 0.0);
  EXPECT_FALSE(odometry.calibration().disparities().length_error().has_value());
}

TEST(DisparityCalibration, StartsWithALearnedOffset) {
  const SelfCalibration learned = Drive(Constant, true, 120).calibration().learned();
  ASSERT_TRUE(learned.disparities.has_value());
  Odometry next(FeatureWorld::Camera(), VoOptions());
  next.Begin(learned);
  EXPECT_NEAR(Offset(next, 320.0), learned.disparities->coefficients_px(0), 1e-9);
  DriveOn(0, 40, Constant, next);
  EXPECT_NEAR(Offset(next, 320.0), -0.4, 0.1);
  EXPECT_EQ(next.calibration().disparities().check().verdict(), DisparityCheck::Verdict::kAgrees);

  // The camera has been put right, and its calibration file has not been touched.
  Odometry other(FeatureWorld::Camera(), VoOptions());
  other.Begin(learned);
  DriveOn(0, 200, Nothing, other);
  EXPECT_NEAR(Offset(other, 320.0), 0.0, 0.2);
}

TEST(DisparityCalibration, ConstantOffsetIsFound) {
  const Odometry odometry = Drive(Constant, true, 120);
  EXPECT_NEAR(odometry.calibration().disparities().check().Estimate_px(320.0), -0.4, 0.1);
  EXPECT_LT(Offset(odometry, 320.0), -0.1);
  EXPECT_NEAR(Offset(odometry, 320.0), -0.4, 0.2);
}

TEST(DisparityCalibration, SquareOffsetIsFound) {
  const auto error_px = [](double u_px, double) { return 1.0 * (u_px - 320.0) * (u_px - 320.0) / (400.0 * 400.0); };
  const Odometry odometry = Drive(error_px);
  const DisparityCalibration& calibration = odometry.calibration().disparities();
  EXPECT_NEAR(calibration.check().Estimate_px(600.0) - calibration.check().Estimate_px(320.0), error_px(600.0, 0.0),
              0.2);
}

TEST(DisparityCalibration, LargeOffsetIsApplied) {
  const Odometry odometry = Drive([](double, double) { return 3.0; }, true, 200);
  for (const double u_px : {100.0, 320.0, 540.0}) EXPECT_NEAR(Offset(odometry, u_px), 3.0, 0.3) << u_px;
}

TEST(DisparityCalibration, SlopeIsApplied) {
  const Odometry odometry = Drive([](double u_px, double) { return 1.4 * u_px / 640.0; }, true, 120);
  EXPECT_NEAR(Offset(odometry, 540.0), 1.4 * 540.0 / 640.0, 0.3);
}

// Estimated over true distance between two frames.
double LengthRatio(const Error& error_px, bool enabled) {
  constexpr int kFirst = 100;
  constexpr int kLast = 140;
  Odometry odometry = Drive(error_px, enabled, kFirst + 1);
  const SE3 T_odom_first = odometry.T_odom_c();
  DriveOn(kFirst + 1, kLast + 1, error_px, odometry);
  const SE3 T_first_last = DrivenPoseAt(kFirst).Inverse() * DrivenPoseAt(kLast);
  return (T_odom_first.Inverse() * odometry.T_odom_c()).translation().norm() / T_first_last.translation().norm();
}

TEST(DisparityCalibration, LengthsAreRightDespiteAnOffset) {
  const Error offset = [](double, double) { return -1.2; };
  EXPECT_NEAR(LengthRatio(offset, true), 1.0, 0.05);
  EXPECT_GT(LengthRatio(offset, false), 1.07) << "without the calibration";
}

// Too small a disparity makes everything too far, by the share that it lacks.
TEST(DisparityCalibration, ReportsTheEffectOnLengths) {
  const Odometry odometry = Drive([](double, double) { return -1.0; }, true, 120);
  const auto error = odometry.calibration().disparities().length_error();
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->share, 1.0 / MedianDisparity_px(120), 0.3 / MedianDisparity_px(120));
  EXPECT_GT(error->share, 3.0 * error->sigma);
  EXPECT_GT(error->sigma, 0.0);
}

// Features in the left half of the image only.
TEST(DisparityCalibration, MaskedHalfIsNotReported) {
  const FeatureWorld world({1200, 60}, 11);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 120; ++i) {
    StereoFeatures features = world.Observe(DrivenPoseAt(i), kNoise_px, static_cast<uint64_t>(i));
    std::erase_if(features.points, [](const StereoPoint& point) { return point.left.px.x() > 320.0; });
    std::erase_if(features.lines, [](const StereoLine& line) { return line.left.segment.p.x() > 320.0; });
    odometry.Track(i * kDriveFrame_ns, WithError(std::move(features), Constant));
  }
  const auto error = odometry.calibration().disparities().length_error();
  if (error) {
    EXPECT_LT(std::abs(error->share), 0.8 / MedianDisparity_px(120));
  }
}

TEST(DisparityCalibration, UnknownOffsetWidensTheCovariance) {
  const Odometry wrong = Drive([](double, double) { return -1.0; }, true, 3);
  EXPECT_GT(wrong.calibration().disparities().LengthSigma(), 0.01);
  const Odometry known = Drive(Nothing, true, 120);
  EXPECT_LT(known.calibration().disparities().LengthSigma(), 0.01);
}

// Sliding corners and moving objects cause such residuals; an offset of the cameras does not depend on the depth.
TEST(DisparityCalibration, OffsetThatDependsOnDepthIsRejected) {
  const Odometry odometry =
      Drive([](double, double disparity_px) { return 0.01 * std::pow(disparity_px - 12.0, 2); });
  for (const double u_px : {0.0, 320.0, 639.0}) EXPECT_EQ(Offset(odometry, u_px), 0.0);
}

TEST(DisparityCalibration, StateRestoresAllBits) {
  Odometry odometry = Drive(Constant, true, 120);
  const DisparityCalibration& one = odometry.calibration().disparities();
  DisparityCalibration other(FeatureWorld::Camera(), {});
  archive::FromBytes(archive::ToBytes(one), other);
  EXPECT_EQ(archive::ToBytes(other), archive::ToBytes(one));
  EXPECT_EQ(other.Offset_px(320.0), one.Offset_px(320.0));
  EXPECT_NE(other.Offset_px(320.0), 0.0);
}

TEST(DisparityCalibration, DisabledItChangesNothing) {
  const Odometry odometry = Drive(Constant, false);
  EXPECT_EQ(Offset(odometry, 320.0), 0.0);
}

TEST(DisparityCalibration, CorrectionToZeroRemovesTheDepth) {
  const Odometry odometry = Drive([](double, double) { return 0.4; });
  DisparityCalibration calibration = odometry.calibration().disparities();
  StereoFeatures features;
  features.points.resize(3);
  for (StereoPoint& point : features.points) point.left.px = {320.0, 240.0};
  features.points[0].disparity_px = 5.0;
  features.points[1].disparity_px = 0.5 * calibration.Offset_px(320.0);
  calibration.Correct(features);
  EXPECT_NEAR(features.points[0].disparity_px, 5.0 - calibration.Offset_px(320.0), 1e-12);
  EXPECT_FALSE(features.points[1].HasDepth()) << "nothing is left of it";
  EXPECT_FALSE(features.points[2].HasDepth()) << "it never had one";
}

TEST(DisparityCalibration, StandingCameraLearnsNothing) {
  const FeatureWorld world({400, 60}, 11);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 60; ++i) {
    StereoFeatures features = world.Observe(DrivenPoseAt(0), kNoise_px, static_cast<uint64_t>(i));
    odometry.Track(i * kDriveFrame_ns, WithError(std::move(features), Constant));
  }
  EXPECT_EQ(Offset(odometry, 320.0), 0.0);
}

TEST(DisparityCalibration, OffsetOfImagesIsFound) {
  const auto dataset = OpenDataset("synthetic:street?frames=60&disparity_bias=0,0,-0.5", "");
  const VoOptions options;
  StereoFrontEnd front_end(dataset->rig(), options);
  Odometry odometry(front_end.camera(), options);
  StageTimer timer(test::SteadyMs);
  for (int i = 0; i < dataset->size(); ++i) {
    const StereoImages images = dataset->Read(i);
    odometry.Track(images.t_ns, odometry.SeePair(front_end, images, timer));
  }
  const DisparityCalibration& calibration = odometry.calibration().disparities();
  EXPECT_NEAR(calibration.check().Estimate_px(752.0 / 6.0), 0.0, 0.1);
  EXPECT_NEAR(calibration.check().Estimate_px(752.0 / 2.0), 0.0, 0.1);
  EXPECT_NEAR(calibration.check().Estimate_px(752.0 * 5.0 / 6.0), -0.5, 0.1);
  EXPECT_LT(calibration.Offset_px(752.0 * 5.0 / 6.0), -0.2);
}

}  // namespace
}  // namespace plslam::vo
