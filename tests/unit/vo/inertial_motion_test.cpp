// SPDX-License-Identifier: BSD-3-Clause
// Odometry with an inertial sensor.
#include "vo_process/tracking/motion/inertial_motion_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

std::vector<OdometryFrame> RunInTheDark(const std::string& world, const VoOptions& options = {}) {
  const auto dataset = OpenDataset("synthetic:" + world + "&imu=200&size=320x240&frames=100", "");
  test::Worsening worsening;
  worsening.black_first = kFirstBlack;
  worsening.black_count = kBlack;
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

TEST(InertialMotion, WithoutTheSensorBlackFramesAreLost) {
  VoOptions options;
  options.imu.enabled = false;
  EXPECT_GE(test::LostFrames(RunInTheDark("room?seed=1", options)), kBlack);
}

/// A world whose samples were scaled.
class Scaled : public test::ChangedImages {
 public:
  Scaled(const Dataset& dataset, double rate, double force) : ChangedImages(dataset), samples_(dataset.ImuSamples()) {
    for (ImuSample& sample : samples_) {
      sample.rate_rad_s *= rate;
      sample.force_m_s2 *= force;
    }
  }
  StereoImages Read(int index) const override { return dataset_.Read(index); }
  const std::vector<ImuSample>& ImuSamples() const override { return samples_; }

 private:
  std::vector<ImuSample> samples_;
};

// A sensor in degrees a second contradicts the images, and changes nothing.
TEST(InertialMotion, SensorThatContradictsTheImagesIsNotUsed) {
  const auto dataset = OpenDataset("synthetic:room?imu=200&size=320x240&frames=80", "");
  VoOptions without;
  without.imu.enabled = false;
  const auto expected = test::RunOdometry(*dataset, without);
  const auto frames = test::RunOdometry(Scaled(*dataset, 1.0 / kRadPerDeg, 1.0), {});
  ASSERT_EQ(frames.size(), expected.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ((frames[i].T_odom_l.Inverse() * expected[i].T_odom_l).Log().norm(), 0.0) << i;
  }
}

TEST(InertialMotion, FaultsAreNamedWithTheirNumber) {
  const auto dataset = OpenDataset("synthetic:room?imu=200&size=320x240&frames=100", "");
  const auto complaint = [&](double rate, double force) {
    const Scaled scaled(*dataset, rate, force);
    InertialMotionModel inertial(MountedImuOf(scaled.rig()));
    for (int i = 1; i < scaled.size(); ++i) {
      inertial.Expect(scaled.ImuSamples(), scaled.t_ns(i - 1), scaled.t_ns(i));
      Vector6d sigma;
      sigma << Eigen::Vector3d::Constant(0.002), Eigen::Vector3d::Constant(0.001);
      inertial.Observe(scaled.GroundTruth(0)->Inverse() * *scaled.GroundTruth(i), sigma.cwiseAbs2().asDiagonal(),
                       true, false);
    }
    return inertial.Complaint();
  };
  EXPECT_EQ(complaint(1.0, 1.0), "");
  EXPECT_THAT(complaint(1.0 / kRadPerDeg, 1.0), testing::HasSubstr("times as fast as the images: degrees"));
  EXPECT_THAT(complaint(1.0, 1.0 / 9.81), testing::HasSubstr("g instead of m/s^2?"));
}

}  // namespace
}  // namespace plslam::vo
