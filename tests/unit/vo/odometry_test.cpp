// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/odometry.h"

#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/feature_world.h"
#include "tests/unit/vo/feature_path.h"

namespace plslam::vo {
namespace {

using test::FeatureWorld;
using test::kFrame_ns;
using test::PathAt;

// Features of the pose on the path, with the frame number as noise seed.
StereoFeatures SeenAt(const FeatureWorld& world, int frame, double noise_px = 0.3) {
  return world.Observe(PathAt(frame), noise_px, static_cast<uint64_t>(frame));
}

double PositionError(const OdometryResult& result, int frame) {
  return (result.T_odom_c.translation() - (PathAt(0).Inverse() * PathAt(frame)).translation()).norm();
}

bool IsSane(const OdometryResult& result) {
  return result.T_odom_c.IsFinite() && result.covariance.allFinite() && result.motion_covariance.allFinite();
}

class OdometryByFeatureType : public testing::TestWithParam<FeatureWorld::Counts> {};

TEST_P(OdometryByFeatureType, FollowsAPathWithSmallDrift) {
  const FeatureWorld world(GetParam(), 7);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  OdometryResult result;
  for (int i = 0; i < 60; ++i) {
    result = odometry.Track(i * kFrame_ns, SeenAt(world, i));
    EXPECT_EQ(result.state, TrackingState::kTracking) << "frame " << i;
    ASSERT_TRUE(IsSane(result));
  }
  EXPECT_LT(PositionError(result, 59), 0.02);
}

std::string KindName(const testing::TestParamInfo<FeatureWorld::Counts>& info) {
  return std::to_string(info.param.points) + "Points" + std::to_string(info.param.lines) + "Lines";
}

INSTANTIATE_TEST_SUITE_P(Kinds, OdometryByFeatureType,
                         testing::Values(FeatureWorld::Counts{300, 0}, FeatureWorld::Counts{0, 100},
                                         FeatureWorld::Counts{300, 100}),
                         KindName);

TEST(Odometry, RigOfMillimetresTracksLikeOneOfMetres) {
  const FeatureWorld world({300, 60}, 5);
  constexpr double kScale = 1e-3;  // the pixels are the same: an endoscope, 3 mm from the scene
  StereoCamera small_rig = FeatureWorld::Camera();
  small_rig.baseline_m *= kScale;
  Odometry large(FeatureWorld::Camera(), VoOptions());
  Odometry small(small_rig, VoOptions());
  for (int i = 0; i < 60; ++i) {
    const OdometryResult a = large.Track(i * kFrame_ns, SeenAt(world, i));
    const OdometryResult b = small.Track(i * kFrame_ns, SeenAt(world, i));
    ASSERT_EQ(b.state, a.state) << "frame " << i;
    ASSERT_EQ(b.n_tracked_points, a.n_tracked_points) << "frame " << i;
    ASSERT_EQ(b.n_tracked_lines, a.n_tracked_lines) << "frame " << i;
    ASSERT_EQ(b.keyframe.has_value(), a.keyframe.has_value()) << "frame " << i;
    ASSERT_LT((b.T_odom_c.translation() / kScale - a.T_odom_c.translation()).norm(), 1e-3) << "frame " << i;
  }
}

TEST(Odometry, FrameToFrameDriftsMoreThanLandmarks) {
  const FeatureWorld world({300, 60}, 3);
  VoOptions paper;
  paper.tracking.reference = TrackingReference::kPreviousFrame;
  Odometry landmarks(FeatureWorld::Camera(), VoOptions());
  Odometry frame_to_frame(FeatureWorld::Camera(), paper);
  double error_landmarks = 0.0;
  double error_frames = 0.0;
  for (int i = 0; i < 80; ++i) {
    error_landmarks += PositionError(landmarks.Track(i * kFrame_ns, SeenAt(world, i)), i);
    error_frames += PositionError(frame_to_frame.Track(i * kFrame_ns, SeenAt(world, i)), i);
  }
  EXPECT_LT(error_landmarks, error_frames);
  EXPECT_LT(error_frames / 80, 0.05);
}

TEST(Odometry, StandingStillHasNoDriftAndOneKeyframe) {
  const FeatureWorld world({300, 60}, 5);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  int keyframes = 0;
  for (int i = 0; i < 100; ++i) {
    const OdometryResult result = odometry.Track(i * kFrame_ns, world.Observe(PathAt(0), 0.3, i));
    keyframes += result.keyframe ? 1 : 0;
    EXPECT_LT(result.T_odom_c.translation().norm(), 0.003) << "frame " << i;
  }
  EXPECT_EQ(keyframes, 1);
}

TEST(Odometry, IdenticalFramesGiveZeroMotion) {
  const FeatureWorld world({300, 60}, 5);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 5; ++i) {
    const OdometryResult result = odometry.Track(i * kFrame_ns, SeenAt(world, 0));
    EXPECT_LT(result.T_odom_c.Log().norm(), 1e-9);
    ASSERT_TRUE(IsSane(result));
  }
}

TEST(Odometry, FramesWithoutFeaturesAreLostAndThenRecovered) {
  const FeatureWorld world({300, 60}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 10; ++i) odometry.Track(i * kFrame_ns, SeenAt(world, i));
  for (int i = 10; i < 20; ++i) {
    const OdometryResult dark = odometry.Track(i * kFrame_ns, {});
    EXPECT_EQ(dark.state, TrackingState::kLost);
    ASSERT_TRUE(IsSane(dark));
  }
  const OdometryResult back = odometry.Track(20 * kFrame_ns, SeenAt(world, 20));
  EXPECT_EQ(back.state, TrackingState::kRecovered);
  EXPECT_TRUE(back.keyframe);
  EXPECT_LT(PositionError(back, 20), 0.02);
  EXPECT_EQ(odometry.Track(21 * kFrame_ns, SeenAt(world, 21)).state, TrackingState::kTracking);
}

TEST(Odometry, AnotherWorldAfterALoss) {
  const FeatureWorld before({300, 60}, 9);
  const FeatureWorld after({300, 60}, 10);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 10; ++i) odometry.Track(i * kFrame_ns, SeenAt(before, i));
  const OdometryResult lost = odometry.Track(10 * kFrame_ns, SeenAt(after, 10));
  EXPECT_EQ(lost.state, TrackingState::kLost);
  const OdometryResult back = odometry.Track(11 * kFrame_ns, SeenAt(after, 11));
  EXPECT_EQ(back.state, TrackingState::kRecovered);
  ASSERT_TRUE(back.keyframe);
  EXPECT_GT(back.keyframe->covariance.trace(), 0.5 * lost.motion_covariance.trace());
  EXPECT_EQ(odometry.Track(12 * kFrame_ns, SeenAt(after, 12)).state, TrackingState::kTracking);
}

TEST(Odometry, OneForeignFrameDoesNotLoseTheMap) {
  const FeatureWorld world({300, 60}, 9);
  const FeatureWorld strange({300, 60}, 10);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 10; ++i) odometry.Track(i * kFrame_ns, SeenAt(world, i));
  EXPECT_EQ(odometry.Track(10 * kFrame_ns, SeenAt(strange, 10)).state, TrackingState::kLost);
  const OdometryResult back = odometry.Track(11 * kFrame_ns, SeenAt(world, 11));
  EXPECT_EQ(back.state, TrackingState::kRecovered);
  EXPECT_LT(PositionError(back, 11), 0.02);
}

TEST(Odometry, StaysInitialisingUntilThereIsSomethingToSee) {
  const FeatureWorld world({300, 60}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(odometry.Track(i * kFrame_ns, {}).state, TrackingState::kInitialising);
  }
  StereoFeatures one;
  one.points.push_back(SeenAt(world, 0).points.front());
  EXPECT_EQ(odometry.Track(3 * kFrame_ns, one).state, TrackingState::kInitialising);
  EXPECT_EQ(odometry.Track(4 * kFrame_ns, SeenAt(world, 4)).state, TrackingState::kTracking);
}

TEST(Odometry, FewFeaturesAreWeakNotLost) {
  const FeatureWorld world({300, 0}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 10; ++i) odometry.Track(i * kFrame_ns, SeenAt(world, i));
  StereoFeatures few = SeenAt(world, 10);
  few.points.resize(16);
  const OdometryResult result = odometry.Track(10 * kFrame_ns, few);
  EXPECT_EQ(result.state, TrackingState::kWeak);
  EXPECT_LT(PositionError(result, 10), 0.05);
}

// Outside the near window, but not farther than a hand turns a camera.
TEST(Odometry, FewFeaturesThatMoveFarAreWeakNotLost) {
  const FeatureWorld world({300, 0}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 10; ++i) odometry.Track(i * kFrame_ns, SeenAt(world, i));
  const SE3 turn(Eigen::Quaterniond(Eigen::AngleAxisd(0.06, Eigen::Vector3d::UnitY())), Eigen::Vector3d::Zero());
  const SE3 T_w_c = PathAt(10) * turn;
  StereoFeatures few = world.Observe(T_w_c, 0.3, 10);
  few.points.resize(16);
  const OdometryResult result = odometry.Track(10 * kFrame_ns, few);
  EXPECT_EQ(result.state, TrackingState::kWeak);
  EXPECT_LT((T_w_c.Inverse() * result.T_odom_c).Log().norm(), 0.05);
}

TEST(Odometry, FewFeaturesAfterALongGapAreLost) {
  // A picture every second: the motion model allows any position now, so that few features may agree on a wrong one.
  constexpr int64_t kSecond_ns = 1'000'000'000;
  const FeatureWorld world({300, 0}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 10; ++i) odometry.Track(i * kSecond_ns, SeenAt(world, i));
  StereoFeatures few = SeenAt(world, 10);
  few.points.resize(16);
  EXPECT_EQ(odometry.Track(10 * kSecond_ns, few).state, TrackingState::kLost);
  const OdometryResult back = odometry.Track(11 * kSecond_ns, SeenAt(world, 11));
  EXPECT_EQ(back.state, TrackingState::kRecovered);
  EXPECT_LT(PositionError(back, 11), 0.02);
}

TEST(Odometry, StepFarBeyondTheSearchWindowIsFollowed) {
  const FeatureWorld world({300, 60}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 5; ++i) odometry.Track(i * kFrame_ns, SeenAt(world, 0));
  const SE3 step(ExpSO3(Eigen::Vector3d(0.0, 0.25, 0.0)), Eigen::Vector3d(0.5, 0.1, 0.3));
  const OdometryResult result = odometry.Track(5 * kFrame_ns, world.Observe(PathAt(0) * step, 0.3, 5));
  EXPECT_EQ(result.state, TrackingState::kTracking);
  EXPECT_LT((result.T_odom_c.translation() - step.translation()).norm(), 0.02);
}

TEST(Odometry, RepeatedOrDecreasingTimesGiveNoNan) {
  const FeatureWorld world({300, 60}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  odometry.Track(5 * kFrame_ns, SeenAt(world, 0));
  ASSERT_TRUE(IsSane(odometry.Track(5 * kFrame_ns, SeenAt(world, 1))));
  ASSERT_TRUE(IsSane(odometry.Track(2 * kFrame_ns, SeenAt(world, 2))));
}

TEST(Odometry, SecondImageOfTheSameTimeKeepsTheSpeed) {
  const FeatureWorld world({300, 60}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 10; ++i) odometry.Track(i * kFrame_ns, SeenAt(world, i));
  const OdometryResult again = odometry.Track(9 * kFrame_ns, SeenAt(world, 9, 0.5));
  EXPECT_EQ(again.state, TrackingState::kTracking);
  const OdometryResult unseen = odometry.Track(10 * kFrame_ns, {});
  EXPECT_EQ(unseen.state, TrackingState::kLost);
  const Eigen::Vector3d truth = (PathAt(9).Inverse() * PathAt(10)).translation();
  EXPECT_LT((unseen.T_prev_c.translation() - truth).norm(), 0.3 * truth.norm()) << "it moves as before";
}

TEST(Odometry, KeyframesChainToTheOdometryPose) {
  const FeatureWorld world({300, 60}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  SE3 chained;
  int64_t expected = 0;
  for (int i = 0; i < 150; ++i) {
    const OdometryResult result = odometry.Track(i * kFrame_ns, SeenAt(world, i));
    if (!result.keyframe) continue;
    EXPECT_EQ(result.keyframe->id, expected);
    EXPECT_EQ(result.keyframe->previous_id, expected - 1);
    ++expected;
    chained = chained * result.keyframe->T_prevkf_kf;
    EXPECT_LT((chained.Inverse() * result.T_odom_c).Log().norm(), 1e-9) << "keyframe " << result.keyframe->id;
  }
  EXPECT_GT(expected, 3);
}

TEST(Odometry, SameInputSameBits) {
  const FeatureWorld world({300, 60}, 9);
  Odometry a(FeatureWorld::Camera(), VoOptions());
  Odometry b(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 40; ++i) {
    const Eigen::Matrix4d A = a.Track(i * kFrame_ns, SeenAt(world, i)).T_odom_c.matrix();
    const Eigen::Matrix4d B = b.Track(i * kFrame_ns, SeenAt(world, i)).T_odom_c.matrix();
    ASSERT_EQ(std::memcmp(A.data(), B.data(), 16 * sizeof(double)), 0) << "frame " << i;
  }
}

}  // namespace
}  // namespace plslam::vo
