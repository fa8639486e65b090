// SPDX-License-Identifier: BSD-3-Clause
// An odometry that is restored from the state of another one continues with bit-identical results.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "core/files/archive.h"
#include "tests/support/feature_world.h"
#include "tests/unit/vo/bent_rig.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

std::vector<uint8_t> Bits(const OdometryResult& result) {
  std::vector<TrackId> landmarks = TrackedLandmarkIds(result.point_tracks);
  for (const FeatureTrack& track : result.line_tracks) landmarks.push_back(track.landmark_id);
  std::vector<double> measured;
  for (const StereoPoint& point : result.features.points) {
    measured.insert(measured.end(), {point.left.px.x(), point.left.px.y(), point.disparity_px, point.sigma_px});
  }
  return archive::ToBytes(static_cast<int>(result.state), result.T_odom_c, result.covariance, result.T_prev_c,
                          result.motion_covariance, result.entropy_ratio, landmarks, measured,
                          result.keyframe ? result.keyframe->inertial : InertialInterval());
}

Odometry Restored(const Odometry& odometry, const StereoCamera& camera, const VoOptions& options,
                  const std::optional<MountedImu>& imu) {
  Odometry restored(camera, options, {}, imu);
  archive::FromBytes(archive::ToBytes(odometry), restored);
  return restored;
}

double Zero() { return 0.0; }

/// Tracks a world twice: once undisturbed, once with an odometry that is restored from its state at each keyframe.
/// Returns the number of frames whose features were followed.
int ExpectSameBits(const Dataset& dataset, int frames, const VoOptions& options) {
  StereoFrontEnd front_end(dataset.rig(), options);
  std::optional<StereoFrontEnd> other_front_end(std::in_place, dataset.rig(), options);
  const std::optional<MountedImu> imu = MountedImuOf(dataset.rig());
  Odometry undisturbed(front_end.camera(), options, RollingShutter(), imu);
  std::optional<Odometry> restored(std::in_place, front_end.camera(), options, RollingShutter(), imu);
  int64_t last_t_ns = 0;
  int n_restored = 0;
  int n_followed = 0;
  for (int i = 0; i < frames; ++i) {
    StageTimer timer(Zero);
    const StereoImages images = dataset.Read(i);
    undisturbed.ExpectImu(dataset.ImuSamples(), last_t_ns, images.t_ns);
    restored->ExpectImu(dataset.ImuSamples(), last_t_ns, images.t_ns);
    last_t_ns = images.t_ns;
    const StereoFeatures features = undisturbed.SeePair(front_end, images, timer);
    const OdometryResult expected = undisturbed.Track(images.t_ns, features);
    const StereoFeatures seen_again = restored->SeePair(*other_front_end, images, timer);
    const OdometryResult result = restored->Track(images.t_ns, seen_again);
    EXPECT_EQ(Bits(result), Bits(expected)) << "frame " << i << ", restored " << n_restored << " times";
    EXPECT_EQ(result.keyframe.has_value(), expected.keyframe.has_value());
    if (testing::Test::HasFailure()) return n_followed;
    n_followed += result.is_followed ? 1 : 0;
    if (!result.keyframe) continue;
    restored.emplace(Restored(*restored, front_end.camera(), options, imu));
    other_front_end.emplace(dataset.rig(), options);
    ++n_restored;
  }
  EXPECT_GE(n_restored, 3);
  EXPECT_EQ(archive::ToBytes(*restored), archive::ToBytes(undisturbed));
  return n_followed;
}

int ExpectSameBits(const char* world, int frames, const VoOptions& options) {
  return ExpectSameBits(*OpenDataset(world, ""), frames, options);
}

TEST(OdometryState, ContinuesBitForBitWithABentRig) {
  const auto straight = OpenDataset("synthetic:room?size=320x240&frames=40", "");
  ExpectSameBits(test::BentRig(*straight, {-0.005, 0.0, 0.01}), 40, VoOptions());
}

TEST(OdometryState, ContinuesBitForBitInSnowAndOutOfStep) {
  ExpectSameBits("synthetic:room?size=320x240&frames=40&right_late_ms=10&streaks=150", 40, VoOptions());
}

TEST(OdometryState, ContinuesBitForBit) {
  EXPECT_GT(ExpectSameBits("synthetic:room?size=320x240&frames=60", 60, VoOptions()), 20);
}

TEST(OdometryState, ContinuesBitForBitWithDescriptors) {
  VoOptions options;
  options.tracking.front_end = FrontEnd::kDescriptors;
  EXPECT_EQ(ExpectSameBits("synthetic:room?size=320x240&frames=60", 60, options), 0);
}

TEST(OdometryState, ContinuesBitForBitWithAnInertialSensor) {
  ExpectSameBits("synthetic:room?size=320x240&frames=60&imu=200", 60, VoOptions());
}

TEST(OdometryState, ContinuesBitForBitFrameToFrame) {
  VoOptions options;
  options.tracking.reference = TrackingReference::kPreviousFrame;
  ExpectSameBits("synthetic:corridor?size=320x240&frames=40", 40, options);
}

TEST(OdometryState, TruncatedBytesAreRefused) {
  const StereoCamera camera = test::FeatureWorld::Camera();
  const std::vector<uint8_t> bytes = archive::ToBytes(Odometry(camera, VoOptions()));
  Odometry odometry(camera, VoOptions());
  EXPECT_THROW(archive::FromBytes(std::span(bytes).first(bytes.size() - 1), odometry), std::runtime_error);
}

}  // namespace
}  // namespace plslam::vo
