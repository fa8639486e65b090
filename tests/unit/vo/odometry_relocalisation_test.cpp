// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/unit/vo/perfect_map.h"

namespace plslam::vo {
namespace {

using test::FeatureWorld;
using test::kT_w_world;
using test::PerfectMap;
using test::PoseAt;
using test::See;

constexpr int64_t kAskingFrame_ns = 50'000'000;

/// A tracker that has tracked 60 frames with a map, and then gets some frames without features.
class Relocalisation : public testing::Test {
 protected:
  Relocalisation() { Walk(0, 60); }
  void Walk(int from, int to) {
    for (int i = from; i < to; ++i) {
      const OdometryResult result = Track(See(world_, i, 0.3));
      if (!result.keyframe) continue;
      map_.Add(1, i, result);
      odometry_.Adopt(map_.map(), {1, result.keyframe->id});
    }
  }
  OdometryResult Track(StereoFeatures features) {
    return odometry_.Track(kAskingFrame_ns * frame_++, std::move(features));
  }
  OdometryResult Blind() { return Track({}); }
  /// Answers as loop_process does for a frame with the view of frame `i`, with an error of a centimetre.
  bool Answer(int i, const SE3& T_odom_c) {
    const SE3 error(ExpSO3(Eigen::Vector3d(0.001, 0.0, 0.0)), Eigen::Vector3d(0.01, 0.0, 0.0));
    KeyframeId keyframe_id = -1;
    double nearest = 1e9;
    for (const auto& [id, keyframe] : map_.map().keyframes()) {
      const double distance = (keyframe.T_w_kf.Inverse() * kT_w_world * PoseAt(i)).Log().norm();
      if (distance < nearest) keyframe_id = id;
      nearest = std::min(nearest, distance);
    }
    return odometry_.Relocalise(map_.map(), keyframe_id, kT_w_world * PoseAt(i) * error * T_odom_c.Inverse());
  }
  double ErrorInMap(const OdometryResult& result, int i) const {
    const SE3 T_w_c = odometry_.T_w_odom() * result.T_odom_c;
    return (T_w_c.translation() - (kT_w_world * PoseAt(i)).translation()).norm();
  }

  FeatureWorld world_{{300, 60}, 4};
  FeatureWorld elsewhere_{{300, 60}, 99};
  Odometry odometry_{FeatureWorld::Camera(), VoOptions()};
  PerfectMap map_{world_};
  int64_t frame_ = 0;
};

TEST_F(Relocalisation, CameraCarriedWhileCovered) {
  Walk(60, 200);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(Blind().state, TrackingState::kLost);
  // Uncovered at the beginning of its path, of which the tracker has no landmarks left.
  const OdometryResult asked = Track(See(world_, 0, 0.3));
  ASSERT_EQ(asked.state, TrackingState::kLost);
  ASSERT_TRUE(Answer(0, asked.T_odom_c));
  const OdometryResult found = Track(See(world_, 1, 0.3));
  EXPECT_EQ(found.state, TrackingState::kRecovered);
  ASSERT_TRUE(found.keyframe);
  EXPECT_LT(ErrorInMap(found, 1), 0.01);
  EXPECT_LT((asked.T_odom_c.Inverse() * found.T_odom_c).translation().norm(), 0.1) << "T_odom_c must not jump";
  EXPECT_GT(found.keyframe->covariance(0, 0), 10.0) << "its motion was not observed";
  for (int i = 2; i < 20; ++i) EXPECT_LT(ErrorInMap(Track(See(world_, i, 0.3)), i), 0.02) << i;
}

TEST_F(Relocalisation, LandmarksOfTheKeyframeHaveMapIds) {
  for (int i = 0; i < 3; ++i) Blind();
  const OdometryResult asked = Blind();
  ASSERT_TRUE(Answer(10, asked.T_odom_c));
  const OdometryResult found = Track(See(world_, 10, 0.3));
  ASSERT_TRUE(found.keyframe);
  const auto named =
      std::count_if(found.keyframe->content.point_tracks.begin(), found.keyframe->content.point_tracks.end(),
                    [](const FeatureTrack& track) { return track.map_id >= 0; });
  EXPECT_GT(named, 30);
}

TEST_F(Relocalisation, WrongAnswerIsRejected) {
  for (int i = 0; i < 5; ++i) Blind();
  const OdometryResult asked = Track(See(elsewhere_, 5, 0.3));
  const SE3 T_w_odom = odometry_.T_w_odom();
  ASSERT_TRUE(Answer(5, asked.T_odom_c));
  const OdometryResult next = Track(See(elsewhere_, 6, 0.3));
  EXPECT_LT((odometry_.T_w_odom().Inverse() * T_w_odom).Log().norm(), 1e-12);
  EXPECT_LT((asked.T_odom_c.Inverse() * next.T_odom_c).translation().norm(), 0.2);
}

TEST_F(Relocalisation, TrackedCameraContinuesWithoutAJump) {
  Odometry visitor(FeatureWorld::Camera(), VoOptions());
  const OdometryResult first = visitor.Track(0, See(world_, 10, 0.3));
  const OdometryResult before = visitor.Track(kAskingFrame_ns, See(world_, 11, 0.3));
  // An error of some centimetres, which the features correct.
  const SE3 error(Eigen::Quaterniond::Identity(), {0.0, 0.05, 0.02});
  ASSERT_TRUE(visitor.Relocalise(map_.map(), 0, kT_w_world * PoseAt(10) * error * first.T_odom_c.Inverse()));
  const OdometryResult found = visitor.Track(2 * kAskingFrame_ns, See(world_, 12, 0.3));
  ASSERT_TRUE(visitor.is_in_map());
  EXPECT_EQ(found.state, TrackingState::kTracking);
  ASSERT_TRUE(found.keyframe) << "the map is to know at once";
  const SE3 truth = PoseAt(11).Inverse() * PoseAt(12);
  EXPECT_LT((truth.Inverse() * (before.T_odom_c.Inverse() * found.T_odom_c)).translation().norm(), 0.005);
  EXPECT_LT(found.keyframe->covariance.trace(), 1e-3) << "the motion is known";
  const auto in_map = [&](const OdometryResult& result, int i) {
    return ((visitor.T_w_odom() * result.T_odom_c).translation() - (kT_w_world * PoseAt(i)).translation()).norm();
  };
  EXPECT_LT(in_map(found, 12), 0.01);
  for (int i = 13; i < 30; ++i)
    EXPECT_LT(in_map(visitor.Track(kAskingFrame_ns * i, See(world_, i, 0.3)), i), 0.02) << i;
}

TEST_F(Relocalisation, KeyframeMissingFromTheMapIsRefused) {
  EXPECT_FALSE(odometry_.Relocalise(map_.map(), 1000, SE3()));
}

TEST_F(Relocalisation, ConstantMapIsTracked) {
  // A tracker without a map of its own.
  Odometry visitor(FeatureWorld::Camera(), VoOptions());
  EXPECT_FALSE(visitor.AdoptAround(map_.map())) << "it has seen nothing";
  const OdometryResult first = visitor.Track(0, See(world_, 10, 0.3));
  EXPECT_FALSE(visitor.is_in_map());
  ASSERT_TRUE(visitor.Relocalise(map_.map(), 0, kT_w_world * PoseAt(10) * first.T_odom_c.Inverse()));
  for (int i = 11; i < 60; ++i) {
    const OdometryResult result = visitor.Track(kAskingFrame_ns * i, See(world_, i, 0.3));
    ASSERT_TRUE(visitor.is_in_map());
    const SE3 T_w_c = visitor.T_w_odom() * result.T_odom_c;
    EXPECT_LT((T_w_c.translation() - (kT_w_world * PoseAt(i)).translation()).norm(), 0.01) << i;
    if (!result.keyframe) continue;
    EXPECT_TRUE(visitor.AdoptAround(map_.map())) << i;
  }
}

}  // namespace
}  // namespace plslam::vo
