// SPDX-License-Identifier: BSD-3-Clause
// Odometry with an inertial sensor.
#include "vo_process/tracking/motion/inertial_motion_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "tests/support/odometry_run.h"
#include "tests/support/worse_images.h"

namespace plslam::vo {
namespace {

using test::ErrorOfMotion;
using test::OdometryFrame;

constexpr int kFirstBlack = 60;
constexpr int kBlack = 20;  // one second

std::vector<OdometryFrame> RunInTheDark(const std::string& world, const VoOptions& options = {}, int n_black = kBlack,
                                        int every = 1 << 30) {
  const int frames = every < 1000 ? kFirstBlack + 2 * every : kFirstBlack + n_black + 20;
  const auto dataset =
      OpenDataset("synthetic:" + world + "&imu=200&size=320x240&frames=" + std::to_string(frames), "");
  test::Worsening worsening;
  worsening.black_first = kFirstBlack;
  worsening.black_count = n_black;
  worsening.black_every = every;
  return test::RunOdometry(test::WorseImages(*dataset, worsening), options);
}

void ExpectCarried(const std::string& world, double bound_m) {
  const std::vector<OdometryFrame> frames = RunInTheDark(world);
  EXPECT_EQ(test::LostFrames(frames), 0) << world;
  double sigma_m = 0.0;
  for (size_t i = kFirstBlack; i < kFirstBlack + kBlack; ++i) {
    EXPECT_EQ(frames[i].state, TrackingState::kWeak);
    const test::MotionError error = ErrorOfMotion(frames, kFirstBlack - 1, i);
    EXPECT_LT(error.translation_m, bound_m) << world << ", frame " << i;
    EXPECT_LT(error.rotation_rad, 0.5 * kRadPerDeg) << world << ", frame " << i;
    EXPECT_LT(error.chi2, kExpectedChi2) << world << ", frame " << i;
    EXPECT_GT(error.sigma_m, sigma_m) << world << ", frame " << i;
    sigma_m = error.sigma_m;
    EXPECT_GT(frames[i].T_prev_c.translation().norm(), 0.01) << "the pose does not freeze";
  }
  EXPECT_EQ(frames[kFirstBlack + kBlack].state, TrackingState::kTracking) << world;
  EXPECT_LT(ErrorOfMotion(frames, kFirstBlack - 1, frames.size() - 1).translation_m, bound_m) << world;
}

TEST(InertialMotion, ASecondOfBlackFramesAtWalkingSpeed) {
  ExpectCarried("room?seed=1", 0.03);
  ExpectCarried("whitewall?seed=1", 0.03);
}

TEST(InertialMotion, ASecondOfBlackFramesAtTenMetresASecond) { ExpectCarried("street?speed=10", 0.3); }

// Two of a longer path; docs/lab/imu.md has a minute.
TEST(InertialMotion, DarkSecondsAreRepeated) {
  constexpr int kEvery = 60;
  const std::vector<OdometryFrame> frames = RunInTheDark("room?seed=1", {}, kBlack, kEvery);
  EXPECT_EQ(test::LostFrames(frames), 0);
  for (const size_t first : {kFirstBlack, kFirstBlack + kEvery}) {
    EXPECT_LT(ErrorOfMotion(frames, first - 1, first + kBlack - 1).translation_m, 0.03) << first;
    EXPECT_EQ(frames[first + kBlack].state, TrackingState::kTracking) << first;
  }
  EXPECT_LT(test::AbsoluteTrajectoryError(frames), 0.03);
}

// The camera sees another part of the room afterwards, and that is not mistaken for where it was.
TEST(InertialMotion, AHundredDarkFrames) {
  constexpr size_t kHundred = 100;
  for (const std::string world : {"room?turning=40", "room?seed=1"}) {
    const std::vector<OdometryFrame> frames = RunInTheDark(world, {}, kHundred);
    EXPECT_EQ(test::LostFrames(frames), 0) << world;
    const test::MotionError error = ErrorOfMotion(frames, kFirstBlack - 1, frames.size() - 1);
    EXPECT_LT(error.rotation_rad, kRadPerDeg) << world;
    EXPECT_LT(error.translation_m, 0.5) << world;
    EXPECT_LT(error.chi2, kExpectedChi2) << world;
    EXPECT_EQ(frames.back().state, TrackingState::kTracking) << world;
  }
}

TEST(InertialMotion, StandingCameraDoesNotDriftInTheDark) {
  const std::vector<OdometryFrame> frames = RunInTheDark("room?standing=1", {}, 100);
  const test::MotionError error = ErrorOfMotion(frames, kFirstBlack - 1, kFirstBlack + 99);
  EXPECT_LT(error.translation_m, 0.01);
  EXPECT_LT(error.rotation_rad, 0.1 * kRadPerDeg);
  EXPECT_LT(error.chi2, kExpectedChi2);
}

/// Frames, and the first sentence about a sensor that is not used.
struct Sensed {
  std::vector<OdometryFrame> frames;
  std::string contradiction;
  std::string samples;
};

Sensed RunWith(const std::string& world, const std::string& fault, int frames) {
  const auto dataset = OpenDataset("synthetic:" + world + "&imu=200&size=320x240&frames=" + std::to_string(frames) +
                                       (fault.empty() ? "" : "&imu_fault=" + fault),
                                   "");
  Sensed sensed{test::RunOdometry(*dataset, VoOptions()), "", ""};
  for (const OdometryFrame& frame : sensed.frames) {
    if (sensed.contradiction.empty()) sensed.contradiction = frame.imu_contradiction;
    if (sensed.samples.empty()) sensed.samples = frame.imu_sample_faults;
  }
  return sensed;
}

/// Runs a world whose sensor has no fault: there is no sentence about it.
std::vector<OdometryFrame> RunWithHealthySensor(const std::string& world) {
  const Sensed sensed = RunWith(world, "", 120);
  EXPECT_EQ(sensed.contradiction + sensed.samples, "") << world;
  EXPECT_TRUE(sensed.frames.back().uses_imu) << world;
  return sensed.frames;
}

TEST(InertialMotion, VerticalIsKnownAfterTwoSeconds) {
  constexpr size_t kTwoSeconds = 40, kFiveSeconds = 100;
  for (const std::string world : {"room?seed=1", "street?speed=10", "room?standing=1"}) {
    const std::vector<OdometryFrame> frames = RunWithHealthySensor(world);
    for (size_t i = kTwoSeconds; i < frames.size(); ++i) {
      ASSERT_TRUE(frames[i].up) << world << ", frame " << i;
      const SE3 T_w_c = *frames[i].T_w_l * frames[i].T_l_c;
      const Eigen::Vector3d truth = T_w_c.rotation().conjugate() * Eigen::Vector3d::UnitZ();
      const double angle_rad = std::acos(std::min(1.0, truth.dot(frames[i].up->direction)));
      // At 10 m/s, six draws have 0.3 to 1.5 degrees after two seconds.
      EXPECT_LT(angle_rad, (i < kFiveSeconds ? 1.75 : 0.75) * kRadPerDeg) << world << ", frame " << i;
      EXPECT_LT(angle_rad, 3.5 * frames[i].up->sigma_rad) << world << ", frame " << i;
    }
    EXPECT_LT(frames.back().up->sigma_rad, kRadPerDeg) << world;
  }
  VoOptions options;
  options.imu.enabled = false;
  const auto dataset = OpenDataset("synthetic:room?imu=200&size=320x240&frames=30", "");
  EXPECT_FALSE(test::RunOdometry(*dataset, options).back().up);
}

// The measured ratios are 0.6 to 0.85; docs/lab/imu.md has them for more worlds.
TEST(InertialMotion, GyroscopeMakesPathsMoreAccurate) {
  VoOptions without;
  without.imu.enabled = false;
  for (const std::string world : {"whitewall?seed=1", "room?turning=40"}) {
    const auto dataset = OpenDataset("synthetic:" + world + "&imu=200&size=320x240&frames=120", "");
    const double without_m = test::AbsoluteTrajectoryError(test::RunOdometry(*dataset, without));
    const double with_m = test::AbsoluteTrajectoryError(RunWithHealthySensor(world));
    EXPECT_LT(with_m, 0.95 * without_m) << world << ", without " << without_m;
  }
}

TEST(InertialMotion, MotionIsAMeasurementUnlessImagesContradictIt) {
  const auto dataset = OpenDataset("synthetic:room?imu=200&size=320x240&frames=60", "");
  InertialMotionModel inertial(MountedImuOf(dataset->rig()));
  const Matrix6d covariance = 1e-8 * Matrix6d::Identity();
  const auto pose = [&](int i) { return dataset->GroundTruth(0)->Inverse() * *dataset->GroundTruth(i); };
  const auto prior = [&](int i, const SE3& T_odom_c) {
    inertial.Expect(dataset->ImuSamples(), dataset->t_ns(i - 1), dataset->t_ns(i));
    return inertial.PriorFrom({pose(i - 1), covariance}, {T_odom_c, covariance});
  };
  for (int i = 1; i < 59; ++i) {
    if (i < 15) {
      EXPECT_FALSE(prior(i, pose(i))) << "not known yet, frame " << i;
    }
    inertial.Expect(dataset->ImuSamples(), dataset->t_ns(i - 1), dataset->t_ns(i));
    inertial.Observe(pose(i), covariance, true, false);
  }
  const auto measured = prior(59, pose(59));
  ASSERT_TRUE(measured);
  const Vector6d error = (measured->T_cur_ref * pose(59)).Log();
  EXPECT_LT(error.tail<3>().norm(), 0.02 * kRadPerDeg);
  EXPECT_LT(std::sqrt(measured->covariance(5, 5)), 0.02 * kRadPerDeg);
  EXPECT_FALSE(prior(59, pose(59) * SE3(ExpSO3(Eigen::Vector3d(0.0, 0.01, 0.0)), Eigen::Vector3d::Zero())));
}

TEST(InertialMotion, WithoutTheSensorBlackFramesAreLost) {
  VoOptions options;
  options.imu.enabled = false;
  EXPECT_GE(test::LostFrames(RunInTheDark("room?seed=1", options)), kBlack);
}

// Rotations over seconds are not linear in the bias.
TEST(InertialMotion, LongMotionsFindALargeBias) {
  const auto dataset = OpenDataset("synthetic:room?imu=200&size=320x240&frames=200", "");
  const auto pose = [&](int frame) { return dataset->GroundTruth(0)->Inverse() * *dataset->GroundTruth(frame); };
  const auto after = [&](const std::vector<ImuSample>& samples, const std::vector<int>& frames) {
    InertialMotionModel inertial(MountedImuOf(dataset->rig()));
    inertial.Start(SE3());
    int previous = 0;
    for (const int frame : frames) {
      inertial.Expect(samples, dataset->t_ns(previous), dataset->t_ns(frame));
      inertial.Observe(pose(frame), 1e-6 * Matrix6d::Identity(), true, false);
      previous = frame;
    }
    return inertial;
  };
  std::vector<int> all(199);
  std::iota(all.begin(), all.end(), 1);
  const Eigen::Vector3d own_rad_s = after(dataset->ImuSamples(), all).filter().state().bias.rate_rad_s;
  const Eigen::Vector3d added_rad_s(0.06, -0.08, 0.05);
  std::vector<ImuSample> samples = dataset->ImuSamples();
  for (ImuSample& sample : samples) sample.rate_rad_s += added_rad_s;
  const InertialMotionModel inertial = after(samples, {120, 140, 160, 180, 199});
  EXPECT_LT((inertial.filter().state().bias.rate_rad_s - own_rad_s - added_rad_s).norm(), 0.003);
  ASSERT_TRUE(inertial.Up());
  const Eigen::Vector3d truth = dataset->GroundTruth(199)->rotation().conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, truth.dot(inertial.Up()->direction))), kRadPerDeg);
}

// A sensor in degrees a second contradicts the images, and changes nothing.
TEST(InertialMotion, SensorThatContradictsTheImagesIsNotUsed) {
  const auto dataset = OpenDataset("synthetic:room?imu=200&size=320x240&frames=80", "");
  VoOptions without;
  without.imu.enabled = false;
  const auto expected = test::RunOdometry(*dataset, without);
  for (const std::string fault : {"degrees", "extrinsics"}) {
    const Sensed sensed = RunWith("room?seed=1", fault, 80);
    ASSERT_EQ(sensed.frames.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ((sensed.frames[i].T_odom_l.Inverse() * expected[i].T_odom_l).Log().norm(), 0.0) << i;
    }
    EXPECT_THAT(sensed.contradiction, testing::HasSubstr(fault == "degrees" ? "degrees instead of rad/s?"
                                                                            : "is T_b_imu the wrong way round?"));
  }
}

// SensorDiagnosis has tests of all faults; here they are found by measured poses.
TEST(InertialMotion, LateSamplesAreNotUsed) {
  const Sensed sensed = RunWith("whitewall?seed=1", "offset", 80);
  EXPECT_THAT(sensed.contradiction, testing::HasSubstr("ms late: time_offset_s: -0.0"));
  for (size_t i = 30; i < sensed.frames.size(); ++i) EXPECT_FALSE(sensed.frames[i].uses_imu) << i;
}

TEST(InertialMotion, StuckSensorIsMissingAtOnce) {
  const Sensed sensed = RunWith("room?seed=1", "stuck&imu_fault_size=2", 80);
  EXPECT_THAT(sensed.contradiction, testing::HasSubstr("while the images move: it is stuck"));
  for (size_t i = 44; i < sensed.frames.size(); ++i) EXPECT_FALSE(sensed.frames[i].uses_imu) << i;
}

// A gap of 0.3 s every three seconds.
TEST(InertialMotion, GapsLeaveTheVertical) {
  const Sensed sensed = RunWith("room?seed=1", "gaps", 160);
  EXPECT_EQ(sensed.contradiction, "");
  int n_used = 0;
  for (size_t i = 40; i < sensed.frames.size(); ++i) {
    EXPECT_TRUE(sensed.frames[i].up) << i;
    n_used += sensed.frames[i].uses_imu ? 1 : 0;
  }
  EXPECT_GE(n_used, 90) << "of 120, of which 12 to 14 are in gaps";
}

// A lead car agrees with any sensor, the world not with a faulty one. With late samples the car became the world (8.5 m).
TEST(InertialMotion, FaultySensorMakesNoBodyTheWorld) {
  constexpr int kFrames = 80;
  const auto error_m = [](const std::string& sensor) {
    const auto dataset = OpenDataset("synthetic:street?body=lead&frames=" + std::to_string(kFrames) + sensor, "");
    return test::AbsoluteTrajectoryError(test::RunOdometry(*dataset, VoOptions()));
  };
  const double without_m = error_m("");
  for (const std::string fault : {"saturated", "offset"}) {
    EXPECT_LT(error_m("&imu=200&imu_fault=" + fault), 2.0 * without_m) << fault;
  }
}

}  // namespace
}  // namespace plslam::vo
