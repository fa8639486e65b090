// SPDX-License-Identifier: BSD-3-Clause
// The robot's own odometry as a prediction: its benefit while the camera is covered, and that wrong odometry does no
// harm.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "tests/support/feature_world.h"
#include "tests/unit/vo/feature_path.h"
#include "vo_process/tracking/motion/robot_motion_model.h"
#include "vo_process/tracking/motion/robot_path.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

using test::FeatureWorld;
using test::kFrame_ns;

constexpr double kFrame_s = 1e-9 * static_cast<double>(kFrame_ns);

/// x right, y down, z forward on a mast ahead of the wheels.
SE3 BodyFromMast() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {R, {0.3, 0.1, 0.8}};
}

/// A curve at 0.6 m/s.
SE3 At(int frame) { return test::PathAt(3.0 * frame); }

SE3 Step(int frame) { return At(frame - 1).Inverse() * At(frame); }

/// Returns wheel odometry that measures `scale` times the true motion.
RobotMotion Wheels(int frame, double scale) {
  const SE3 T_b_c = BodyFromMast();
  return {SE3::Exp(scale * (T_b_c * Step(frame) * T_b_c.Inverse()).Log()), true, T_b_c};
}

double SquaredError(const SE3& estimate, const SE3& truth, const Matrix6d& covariance) {
  const Vector6d off = (truth.Inverse() * estimate).Log();
  return off.dot(covariance.ldlt().solve(off));
}

RobotMotionModel Believed() {
  RobotMotionModel model;
  for (int i = 1; i <= 20; ++i) {
    model.Expect(Wheels(i, 1.0));
    model.Observe(Step(i), Matrix6d::Zero(), kFrame_s, true);
  }
  return model;
}

TEST(RobotMotionModel, ConvertsBodyMotionToCameraMotion) {
  RobotMotionModel model = Believed();
  ASSERT_TRUE(model.agrees());
  model.Expect(Wheels(21, 1.0));
  const MotionPrediction prediction = model.Predict({}, kFrame_s);
  EXPECT_TRUE(prediction.by_robot);
  EXPECT_LT((prediction.T_prev_c.Inverse() * Step(21)).Log().norm(), 1e-12);
  const double tilt_rad = 1.0 * kRadPerDeg;
  EXPECT_GT(std::sqrt(prediction.covariance(5, 5)), tilt_rad);
  EXPECT_GT(std::sqrt(prediction.covariance(0, 0)), 0.8 * tilt_rad) << "a mast that tilts moves the camera";
}

TEST(RobotMotionModel, NotUsedBeforeHalfASecondOfAgreement) {
  MotionPrediction own;
  own.T_prev_c = Step(7);
  RobotMotionModel model;
  for (int i = 1; i < 10; ++i) {
    model.Expect(Wheels(i, 1.0));
    EXPECT_FALSE(model.Predict(own, kFrame_s).by_robot);
    model.Observe(Step(i), Matrix6d::Zero(), kFrame_s, true);
  }
  EXPECT_FALSE(model.agrees());
  model = Believed();
  model.Expect(std::nullopt);
  EXPECT_FALSE(model.Predict(own, kFrame_s).by_robot);
  EXPECT_LT((model.Predict(own, kFrame_s).T_prev_c.Inverse() * own.T_prev_c).Log().norm(), 1e-15);
}

TEST(RobotMotionModel, NotUsedAfterTheWheelsHaveSlipped) {
  for (const double scale : {0.0, 0.5, 2.0}) {
    RobotMotionModel model = Believed();
    for (int i = 21; i <= 40; ++i) {
      model.Expect(Wheels(i, scale));
      model.Observe(Step(i), Matrix6d::Zero(), kFrame_s, true);
    }
    EXPECT_FALSE(model.agrees()) << scale;
  }
}

TEST(RobotMotionModel, NotUsedIfTheCameraContradictsIt) {
  RobotMotionModel model = Believed();
  RobotMotion motion = Wheels(21, 1.0);
  motion.T_fromb_b = motion.T_fromb_b * SE3(Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0});
  model.Expect(motion);
  MotionModel own;
  own.Observe(Step(20), kFrame_s, Matrix6d::Zero());
  EXPECT_FALSE(model.Predict(own.Predict(kFrame_s), kFrame_s).by_robot);
}

// Wheels with too small a scale have the same error in each frame.
TEST(RobotMotionModel, ErrorsOfFramesAddUpWithThePath) {
  RobotMotionModel model = Believed();
  Matrix6d covariance = Matrix6d::Zero();
  SE3 robot;
  for (int i = 21; i <= 60; ++i) {
    model.Expect(Wheels(i, 0.95));
    const MotionPrediction prediction = model.Predict({}, kFrame_s);
    ASSERT_TRUE(prediction.by_robot);
    covariance = ComposeCovariance(covariance, prediction.T_prev_c, prediction.covariance);
    robot = robot * prediction.T_prev_c;
    model.Miss(prediction.T_prev_c, kFrame_s);
  }
  const SE3 truth = At(20).Inverse() * At(60);
  EXPECT_LT(SquaredError(robot, truth, covariance), 6.0);
  EXPECT_GT(SquaredError(robot, truth, covariance), 0.1) << "too little confidence";
}

TEST(RobotMotionModel, CountsFromTheLastMeasuredFrame) {
  RobotMotionModel model = Believed();
  constexpr int64_t kAt20_ns = 20 * kFrame_ns;
  EXPECT_EQ(model.MeasuredAt(kAt20_ns), kAt20_ns);
  // Two frames are taken to have stood still.
  model.Expect(std::nullopt);
  model.Miss(SE3(), kFrame_s);
  model.Miss(SE3(), kFrame_s);
  EXPECT_EQ(model.MeasuredAt(kAt20_ns + 2 * kFrame_ns), kAt20_ns);
  const SE3 T_b_c = BodyFromMast(), T_seen_c = At(20).Inverse() * At(23);
  model.Expect(RobotMotion{T_b_c * T_seen_c * T_b_c.Inverse(), false, T_b_c});
  EXPECT_LT((model.Predict({}, kFrame_s).T_prev_c.Inverse() * T_seen_c).Log().norm(), 1e-12);
  model.Observe(T_seen_c, Matrix6d::Zero(), kFrame_s, true);
  EXPECT_EQ(model.MeasuredAt(23 * kFrame_ns), 23 * kFrame_ns);
}

struct Drive {
  double ate_m = 0.0;
  double end_m = 0.0;
  double end_chi2 = 0.0;
  int n_lost = 0;
};

/// Result of odometry over frames 0 to 79, dark where `is_dark`, with wheels that measure a share of each step.
Drive DriveWith(const std::function<bool(int)>& is_dark, const std::function<std::optional<double>(int)>& wheels) {
  const FeatureWorld world({300, 60}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  Drive drive;
  constexpr int kFrames = 80;
  for (int i = 0; i < kFrames; ++i) {
    const std::optional<double> share = i > 0 ? wheels(i) : std::nullopt;
    if (share) odometry.ExpectRobot(Wheels(i, *share));
    const OdometryResult result =
        odometry.Track(i * kFrame_ns, is_dark(i) ? StereoFeatures() : world.Observe(At(i), 0.3, i));
    const SE3 truth = At(0).Inverse() * At(i);
    drive.end_m = (result.T_odom_c.translation() - truth.translation()).norm();
    drive.ate_m += drive.end_m * drive.end_m / kFrames;
    if (i > 0) drive.end_chi2 = SquaredError(result.T_odom_c, truth, result.covariance);
    if (result.state == TrackingState::kLost) ++drive.n_lost;
  }
  drive.ate_m = std::sqrt(drive.ate_m);
  return drive;
}

bool Never(int) { return false; }

/// Wheels whose poses arrive five frames at a time from the 60th frame on.
class LateWheels {
 public:
  void ExpectIn(Odometry& odometry, int frame) {
    const SE3 T_b_c = BodyFromMast();
    for (; (frame < 60 || frame % 5 == 4) && next_ <= frame; ++next_) {
      path_.Add(next_ * kFrame_ns, T_b_c * At(next_) * T_b_c.Inverse());
    }
    const int64_t prev_t_ns = (frame - 1) * kFrame_ns;
    const int64_t from_ns = odometry.motion().robot().MeasuredAt(prev_t_ns);
    const auto motion = path_.Motion(from_ns, frame * kFrame_ns);
    odometry.ExpectRobot(motion ? std::optional(RobotMotion{*motion, false, T_b_c}) : std::nullopt);
  }

 private:
  RobotPath path_;
  int next_ = 0;
};

TEST(RobotMotionPrediction, LatePosesCorrectWhatWasPredicted) {
  const FeatureWorld world({300, 60}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  LateWheels wheels;
  constexpr int kFrames = 80;
  double end_m = 0.0, end_chi2 = 0.0;
  for (int i = 0; i < kFrames; ++i) {
    wheels.ExpectIn(odometry, i);
    const OdometryResult result =
        odometry.Track(i * kFrame_ns, i >= 60 ? StereoFeatures() : world.Observe(At(i), 0.3, i));
    const SE3 truth = At(0).Inverse() * At(i);
    end_m = (result.T_odom_c.translation() - truth.translation()).norm();
    if (i > 0) end_chi2 = SquaredError(result.T_odom_c, truth, result.covariance);
  }
  EXPECT_LT(end_m, 0.02);
  EXPECT_LT(end_chi2, 12.6);
}

// The last second of a curve in the dark.
TEST(RobotMotionPrediction, CarriesACoveredCameraThroughACurve) {
  const auto dark = [](int i) { return i >= 60; };
  const double way_m = (At(59).Inverse() * At(79)).translation().norm();
  const Drive without = DriveWith(dark, [](int) { return std::nullopt; });
  EXPECT_GT(without.end_m, 0.5 * way_m);
  for (const double share : {1.0, 0.95, 1.05}) {
    const Drive with = DriveWith(dark, [&](int) { return share; });
    EXPECT_LT(with.end_m, std::abs(1.0 - share) * way_m + 0.02) << share << ", without " << without.end_m;
    EXPECT_LT(with.end_chi2, 12.6) << share;
  }
  RecordProperty("without_m", std::to_string(without.end_m));
}

TEST(RobotMotionPrediction, UncoveredCameraIsAtTheWheelOdometryPose) {
  const auto dark = [](int i) { return i >= 45 && i < 65; };
  const Drive with = DriveWith(dark, [](int) { return 0.97; });
  const Drive without = DriveWith(dark, [](int) { return std::nullopt; });
  EXPECT_LT(with.end_m, 0.06) << "without " << without.end_m;
  EXPECT_LE(with.n_lost, 21);
}

TEST(RobotMotionPrediction, SlippingWheelsDoNotHarmGoodImages) {
  const Drive without = DriveWith(Never, [](int) { return std::nullopt; });
  const auto expect_as_without = [&](const std::string& what, const std::function<double(int)>& share) {
    const Drive with = DriveWith(Never, share);
    EXPECT_NEAR(with.ate_m, without.ate_m, 0.1 * without.ate_m) << what;
    EXPECT_EQ(with.n_lost, 0) << what;
  };
  expect_as_without("all is well", [](int) { return 1.0; });
  for (const double share : {0.0, 0.5, 2.0}) {
    const std::string name = std::to_string(share);
    expect_as_without(name + " of the way", [&](int) { return share; });
    expect_as_without(name + " of the way from now on", [&](int i) { return i < 40 ? 1.0 : share; });
    expect_as_without(name + " of the way now and then", [&](int i) { return i % 15 < 11 ? 1.0 : share; });
  }
  expect_as_without("backwards", [](int i) { return i < 40 ? 1.0 : -1.0; });
}

TEST(RobotMotionPrediction, SlippedWheelsDoNotMoveACoveredCamera) {
  const auto dark = [](int i) { return i >= 60; };
  const Drive without = DriveWith(dark, [](int) { return std::nullopt; });
  const Drive with = DriveWith(dark, [](int) { return 3.0; });
  EXPECT_NEAR(with.end_m, without.end_m, 1e-9);
}

}  // namespace
}  // namespace plslam::vo
