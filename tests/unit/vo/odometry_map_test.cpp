// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/vo/perfect_map.h"

namespace plslam::vo {
namespace {

using test::FeatureWorld;
using test::kT_w_world;
using test::PerfectMap;
using test::PoseAt;
using test::See;

constexpr int64_t kMappedFrame_ns = 50'000'000;

double DistanceTo(const SE3& T, const SE3& expected) { return (T.translation() - expected.translation()).norm(); }

SE3 Expected(int frame) { return PoseAt(0).Inverse() * PoseAt(frame); }

TEST(OdometryAndMap, KeyframeMissingFromTheMapChangesNothing) {
  const FeatureWorld world({300, 60}, 4);
  Odometry with(FeatureWorld::Camera(), VoOptions());
  Odometry without(FeatureWorld::Camera(), VoOptions());
  PerfectMap map(world);
  for (int i = 0; i < 20; ++i) {
    const OdometryResult a = with.Track(i * kMappedFrame_ns, See(world, i, 0.3));
    const OdometryResult b = without.Track(i * kMappedFrame_ns, See(world, i, 0.3));
    const Eigen::Matrix4d A = a.T_odom_c.matrix();
    const Eigen::Matrix4d B = b.T_odom_c.matrix();
    ASSERT_EQ(std::memcmp(A.data(), B.data(), 16 * sizeof(double)), 0) << "frame " << i;
    if (a.keyframe) map.Add(1, i, a);
    EXPECT_FALSE(with.Adopt(map.map(), {2, 0}));
    EXPECT_FALSE(with.Adopt(map.map(), {1, 1000}));
    EXPECT_LT(with.T_w_odom().Log().norm(), 1e-15);
  }
}

TEST(OdometryAndMap, NewSessionContinuesTrackingInTheMap) {
  const FeatureWorld world({300, 60}, 4);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  Odometry without(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 20; ++i) {
    if (i == 11) odometry.BeginSession();
    const OdometryResult result = odometry.Track(i * kMappedFrame_ns, See(world, i, 0.3));
    const OdometryResult expected = without.Track(i * kMappedFrame_ns, See(world, i, 0.3));
    EXPECT_EQ(result.state, expected.state);
    EXPECT_LT(DistanceTo(result.T_odom_c, expected.T_odom_c), 1e-12) << "frame " << i;
    if (i != 11) continue;
    ASSERT_TRUE(result.keyframe.has_value());
    EXPECT_EQ(result.keyframe->id, 0);
    EXPECT_EQ(result.keyframe->previous_id, -1);
    EXPECT_EQ(result.keyframe->reason, KeyframeReason::kFirst);
  }
}

TEST(OdometryAndMap, PosesInOdomDoNotJumpAndMapFromOdometryIsFound) {
  const FeatureWorld world({300, 60}, 4);
  Odometry with(FeatureWorld::Camera(), VoOptions());
  Odometry without(FeatureWorld::Camera(), VoOptions());
  PerfectMap map(world);
  int adopted = 0;
  double worst_with = 0.0;
  for (int i = 0; i < 60; ++i) {
    const OdometryResult result = with.Track(i * kMappedFrame_ns, See(world, i, 0.3));
    EXPECT_EQ(result.state, TrackingState::kTracking) << "frame " << i;
    const OdometryResult alone = without.Track(i * kMappedFrame_ns, See(world, i, 0.3));
    EXPECT_LT(DistanceTo(result.T_odom_c, alone.T_odom_c), 0.01) << "frame " << i;
    worst_with = std::max(worst_with, DistanceTo(result.T_odom_c, Expected(i)));
    if (!result.keyframe) continue;
    map.Add(1, i, result);
    ASSERT_TRUE(with.Adopt(map.map(), {1, result.keyframe->id}));
    ++adopted;
    EXPECT_LT(DistanceTo(with.T_w_odom() * result.T_odom_c, kT_w_world * PoseAt(i)), 0.01) << "frame " << i;
  }
  EXPECT_GE(adopted, 3);
  EXPECT_LT(worst_with, 0.015);
}

// The map of a keyframe arrives when the next one has been seen. Errors of the keyframes' poses in it must not add up to
// two offsets, one of odd and one of even keyframes, between which landmarks would jump.
TEST(OdometryAndMap, LateMapsDoNotMoveTheCamera) {
  const FeatureWorld world({300, 60}, 4);
  VoOptions options;
  options.keyframes.known_share = 1.01;
  Odometry odometry(FeatureWorld::Camera(), options);
  PerfectMap map(world);
  int64_t adopted = 0;
  double worst_m = 0.0;
  for (int i = 0; i < 400; ++i) {
    const auto place = [](int frame) { return frame % 200 < 100 ? frame % 200 : 199 - frame % 200; };
    const OdometryResult result = odometry.Track(kMappedFrame_ns * i, See(world, place(i), 0.3));
    ASSERT_EQ(result.state, TrackingState::kTracking) << "frame " << i;
    if (i > 0) {
      const SE3 T_prev_c = PoseAt(place(i - 1)).Inverse() * PoseAt(place(i));
      worst_m = std::max(worst_m, DistanceTo(result.T_prev_c, T_prev_c));
    }
    if (!result.keyframe) continue;
    const double error_m = result.keyframe->id % 2 == 0 ? 0.005 : -0.005;
    map.Add(1, place(i), result, SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, error_m, 0.0)));
    if (result.keyframe->id > 0 && odometry.Adopt(map.map(), {1, result.keyframe->id - 1})) ++adopted;
  }
  EXPECT_GE(adopted, 10);
  EXPECT_LT(worst_m, 0.01);
}

// A map with an offset of 3 cm.
TEST(OdometryAndMap, LandmarksOfTheMapReplaceOwnOnes) {
  const FeatureWorld world({300, 60}, 4);
  const Eigen::Vector3d shift_w(0.03, 0.0, 0.0);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  PerfectMap map(world, shift_w);
  const OdometryResult first = odometry.Track(0, See(world, 0, 0.0));
  ASSERT_TRUE(first.keyframe);
  map.Add(1, 0, first);
  ASSERT_TRUE(odometry.Adopt(map.map(), {1, 0}));
  const OdometryResult next = odometry.Track(kMappedFrame_ns, See(world, 1, 0.0));
  const SE3 T_w_c = odometry.T_w_odom() * next.T_odom_c;
  const Eigen::Vector3d off = T_w_c.translation() - (kT_w_world * PoseAt(1)).translation();
  EXPECT_LT((off - shift_w).norm(), 0.002) << off.transpose();
}

// Session 1 has mapped the path; session 2 begins at its middle and goes back, where it has not been.
TEST(OdometryAndMap, LandmarksOfTheMapAreTracked) {
  const FeatureWorld world({300, 60}, 4);
  PerfectMap map(world);
  Odometry before(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i <= 40; ++i) {
    const OdometryResult result = before.Track(i * kMappedFrame_ns, See(world, i, 0.3));
    if (result.keyframe) map.Add(1, i, result);
  }
  const int64_t known_points = static_cast<int64_t>(map.map().points().size());
  ASSERT_GT(known_points, 100);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  const OdometryResult first = odometry.Track(0, See(world, 40, 0.3));
  ASSERT_TRUE(first.keyframe);
  map.Add(2, 40, first);
  ASSERT_TRUE(odometry.Adopt(map.map(), {2, 0}));
  EXPECT_LT(DistanceTo(odometry.T_w_odom(), kT_w_world * PoseAt(40)), 0.01);
  std::set<Descriptor> own;
  for (const StereoPoint& point : first.features.points) own.insert(point.left.descriptor);
  int from_map = 0;
  for (int i = 1; i <= 25; ++i) {
    const OdometryResult result = odometry.Track(i * kMappedFrame_ns, See(world, 40 - i, 0.3));
    EXPECT_EQ(result.state, TrackingState::kTracking);
    from_map = 0;
    for (size_t k = 0; k < result.point_tracks.size(); ++k) {
      const FeatureTrack& track = result.point_tracks[k];
      if (track.map_id < 0) continue;
      const MapPoint* point = map.map().FindPoint(track.map_id);
      ASSERT_NE(point, nullptr);
      EXPECT_EQ(point->descriptor, result.features.points[k].left.descriptor) << "frame " << i << " feature " << k;
      from_map += own.contains(point->descriptor) ? 0 : 1;
    }
    const SE3 T_w_c = odometry.T_w_odom() * result.T_odom_c;
    EXPECT_LT(DistanceTo(T_w_c, kT_w_world * PoseAt(40 - i)), 0.01) << "frame " << i;
  }
  EXPECT_GT(from_map, 30) << "points that session 2 never created";
}

void ExpectNamesAreUnique(const OdometryResult& result, int frame) {
  for (const auto* tracks : {&result.point_tracks, &result.line_tracks}) {
    std::set<TrackId> ids;
    for (const FeatureTrack& track : *tracks) {
      if (track.landmark_id >= 0) {
        EXPECT_TRUE(ids.insert(track.landmark_id).second) << "frame " << frame << " id " << track.landmark_id;
      }
    }
  }
}

// Keyframes of each of `ways` over 100 frames, forth and back in turn.
std::vector<int> KeyframesOfWays(int ways, const VoOptions& options) {
  const FeatureWorld world{{300, 60}, 4};
  PerfectMap map(world);
  Odometry odometry(FeatureWorld::Camera(), options);
  std::vector<int> keyframes;
  for (int i = 0; i < 100 * ways; ++i) {
    if (i % 100 == 0) keyframes.push_back(0);
    const int place = i % 200 < 100 ? i % 200 : 199 - i % 200;
    const OdometryResult result = odometry.Track(kMappedFrame_ns * i, See(world, place, 0.3));
    EXPECT_EQ(result.state, TrackingState::kTracking) << "frame " << i;
    if (!result.keyframe) continue;
    ++keyframes.back();
    map.Add(1, place, result);
    odometry.Adopt(map.map(), {1, result.keyframe->id});
  }
  return keyframes;
}

TEST(OdometryAndMap, MappedPlacesNeedHardlyAnyKeyframes) {
  const std::vector<int> known = KeyframesOfWays(10, VoOptions());
  VoOptions options;
  options.keyframes.known_share = 1.01;
  const std::vector<int> always = KeyframesOfWays(10, options);
  EXPECT_EQ(known.front(), always.front()) << "no keyframe has observed it";
  EXPECT_GE(always.front(), 4);
  EXPECT_GE(always.back(), 4);
  options = {};
  options.map.localise_only = true;
  EXPECT_EQ(KeyframesOfWays(10, options), always) << "keyframes are where the view is new";
  EXPECT_LE(known.back(), 1) << testing::PrintToString(known) << " of " << testing::PrintToString(always);
}

// Lost in the dark, or among unknown features: the local map still describes the previous position, and tracking
// continues there.
TEST(OdometryAndMap, MapIsAdoptedWhileLost) {
  const FeatureWorld world({300, 60}, 4);
  const FeatureWorld strange({300, 60}, 5);
  for (const bool dark : {true, false}) {
    Odometry odometry(FeatureWorld::Camera(), VoOptions());
    PerfectMap map(world);
    std::optional<int64_t> last_keyframe;
    TrackId largest_id = 0;
    for (int i = 0; i < 20; ++i) {
      const OdometryResult result = odometry.Track(i * kMappedFrame_ns, See(world, i, 0.3));
      for (const FeatureTrack& track : result.point_tracks) largest_id = std::max(largest_id, track.landmark_id);
      if (!result.keyframe) continue;
      map.Add(1, i, result);
      last_keyframe = result.keyframe->id;
    }
    ASSERT_TRUE(last_keyframe);
    const OdometryResult lost = odometry.Track(20 * kMappedFrame_ns, dark ? StereoFeatures() : See(strange, 20, 0.3));
    ASSERT_EQ(lost.state, TrackingState::kLost);
    EXPECT_TRUE(odometry.Adopt(map.map(), {1, *last_keyframe}));
    for (int i = 21; i < 30; ++i) {
      const OdometryResult back = odometry.Track(i * kMappedFrame_ns, See(world, i, 0.3));
      EXPECT_EQ(back.state, i == 21 ? TrackingState::kRecovered : TrackingState::kTracking) << "frame " << i;
      EXPECT_LT(DistanceTo(back.T_odom_c, Expected(i)), 0.015) << "frame " << i;
      ExpectNamesAreUnique(back, i);
      int known_to_the_map = 0;
      for (const FeatureTrack& track : back.point_tracks) known_to_the_map += track.map_id >= 0 ? 1 : 0;
      EXPECT_GT(known_to_the_map, 50) << "frame " << i;
    }
  }
}

// Ids of landmarks created while lost and of the map's come from one counter.
TEST(OdometryAndMap, IdsStayUniqueInAnUnknownPlace) {
  const FeatureWorld world({300, 60}, 4);
  const FeatureWorld strange({300, 60}, 5);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  PerfectMap map(world);
  const OdometryResult first = odometry.Track(0, See(world, 0, 0.3));
  map.Add(1, 0, first);
  std::set<TrackId> before;
  for (const FeatureTrack& track : first.point_tracks) before.insert(track.landmark_id);
  ASSERT_EQ(odometry.Track(kMappedFrame_ns, See(strange, 1, 0.3)).state, TrackingState::kLost);
  ASSERT_TRUE(odometry.Adopt(map.map(), {1, 0}));
  const OdometryResult entered = odometry.Track(2 * kMappedFrame_ns, See(strange, 2, 0.3));
  ASSERT_EQ(entered.state, TrackingState::kRecovered);
  ExpectNamesAreUnique(entered, 2);
  for (const FeatureTrack& track : entered.point_tracks) EXPECT_FALSE(before.contains(track.landmark_id));
}

}  // namespace
}  // namespace plslam::vo
