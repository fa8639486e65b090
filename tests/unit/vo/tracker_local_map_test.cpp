// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/tracker_local_map.h"

#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plslam::vo {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr SessionId kSession = 3;
constexpr SessionId kOtherSession = 8;

MapKeyframe KeyframeOf(KeyframeId id, SessionId session, int64_t session_keyframe_id) {
  MapKeyframe keyframe;
  keyframe.id = id;
  keyframe.name.session = session;
  keyframe.name.number = session_keyframe_id;
  const auto k = static_cast<double>(id.value);
  keyframe.T_w_kf = SE3(ExpSO3(Eigen::Vector3d(0.1, 0.2 * k, 0.0)), Eigen::Vector3d(1.0, k, 0.5));
  keyframe.T_odom_kf = SE3(ExpSO3(Eigen::Vector3d(0.0, 0.1 * k, 0.1)), Eigen::Vector3d(k, 0.0, 2.0));
  return keyframe;
}

void PutPoint(LandmarkId id, std::vector<Observation> observations, Map& map) {
  MapPoint point;
  point.id = id;
  point.observations = std::move(observations);
  map.Put(point);
}

void PutLine(LandmarkId id, std::vector<Observation> observations, Map& map) {
  MapLine line;
  line.id = id;
  line.observations = std::move(observations);
  map.Put(line);
}

std::vector<LandmarkId> PointIds(const TrackerLocalMap& patch) {
  std::vector<LandmarkId> ids;
  for (const auto& adopted : patch.points) ids.push_back(adopted.landmark->id);
  return ids;
}

TEST(KeyframeLog, KeyframesMissingFromTheMapGiveNoLocalMap) {
  KeyframeLog log;
  Map map;
  EXPECT_FALSE(log.LocalMapAround(map, {kSession, 0}, 20));
  map.Put(KeyframeOf(0, kOtherSession, 5));
  log.Add(5, {1}, {});
  EXPECT_FALSE(log.LocalMapAround(map, {kSession, 5}, 20)) << "the same number in another session";
  EXPECT_TRUE(log.LocalMapAround(map, {kOtherSession, 5}, 20));
}

TEST(KeyframeLog, MapFromOdometryAsTheKeyframeHasIt) {
  Map map;
  map.Put(KeyframeOf(4, kSession, 2));
  const auto patch = KeyframeLog().LocalMapAround(map, {kSession, 2}, 20);
  ASSERT_TRUE(patch);
  const MapKeyframe expected = KeyframeOf(4, kSession, 2);
  EXPECT_LT((patch->T_w_odom * expected.T_odom_kf * expected.T_w_kf.Inverse()).Log().norm(), 1e-12);
}

TEST(KeyframeLog, LandmarksHaveTheirTrackerIds) {
  KeyframeLog log;
  log.Add(0, {7, -1, 8}, {70});
  log.Add(1, {-1, 9, 7}, {71, 70});
  Map map;
  map.Put(KeyframeOf(0, kSession, 0));
  map.Put(KeyframeOf(1, kOtherSession, 1));
  map.Put(KeyframeOf(2, kSession, 1));
  PutPoint(100, {{0, 0}, {2, 1}}, map);  // the tracker took it for two
  PutPoint(101, {{0, 2}, {1, 1}}, map);  // its other observation is of another camera
  PutPoint(102, {{0, 1}, {2, 0}}, map);  // features without a landmark
  PutPoint(103, {{2, 2}}, map);          // the same name as the first: the map took them for two
  PutPoint(104, {{2, 50}}, map);         // no such feature
  PutLine(200, {{0, 0}, {2, 1}}, map);
  PutLine(201, {{2, 0}}, map);
  const auto patch = log.LocalMapAround(map, {kSession, 1}, 20);
  ASSERT_TRUE(patch);
  EXPECT_THAT(PointIds(*patch), ElementsAre(100, 102, 103, 104)) << "101 is not seen by keyframe 1";
  EXPECT_THAT(patch->points[0].tracker_ids, ElementsAre(7, 9));
  EXPECT_THAT(patch->points[1].tracker_ids, IsEmpty());
  EXPECT_THAT(patch->points[2].tracker_ids, ElementsAre(7));
  EXPECT_THAT(patch->points[3].tracker_ids, IsEmpty());
  ASSERT_EQ(patch->lines.size(), 2u);
  EXPECT_THAT(patch->lines[0].tracker_ids, ElementsAre(70)) << "once, though seen twice";
  EXPECT_THAT(patch->lines[1].tracker_ids, ElementsAre(71));
  const auto before = log.LocalMapAround(map, {kSession, 0}, 20);
  ASSERT_TRUE(before);
  EXPECT_THAT(PointIds(*before), ElementsAre(100, 101, 102));
  EXPECT_THAT(before->points[1].tracker_ids, ElementsAre(8));
}

// Keyframes 1, 2, ... share 14 + their number with keyframe 0, and observe one point of their own.
Map StarOfKeyframes(int neighbours) {
  Map map;
  for (int k = 0; k <= neighbours; ++k) map.Put(KeyframeOf(k, kSession, k));
  int32_t feature = 0;
  for (int k = 1; k <= neighbours; ++k) {
    for (int i = 0; i < 14 + k; ++i, ++feature) PutPoint(1000 * k + i, {{0, feature}, {k, feature}}, map);
    PutPoint(1000 * k + 999, {{k, 5000}}, map);
  }
  return map;
}

TEST(KeyframeLog, BestNeighboursComeFirst) {
  const Map map = StarOfKeyframes(4);
  const auto own_points_of = [&](int max_keyframes) {
    const auto patch = KeyframeLog().LocalMapAround(map, {kSession, 0}, max_keyframes);
    std::vector<int64_t> own;
    for (const LandmarkId id : PointIds(*patch)) {
      if (id.value % 1000 == 999) own.push_back(id.value / 1000);
    }
    return own;
  };
  EXPECT_THAT(own_points_of(1), IsEmpty());
  EXPECT_THAT(own_points_of(2), ElementsAre(4));
  EXPECT_THAT(own_points_of(3), ElementsAre(3, 4));
  EXPECT_THAT(own_points_of(100), ElementsAre(1, 2, 3, 4));
}

TEST(KeyframeLog, OldKeyframesAreForgotten) {
  KeyframeLog log;
  Map map;
  map.Put(KeyframeOf(0, kSession, 0));
  PutPoint(1, {{0, 0}}, map);
  log.Add(0, {7}, {});
  EXPECT_THAT(log.LocalMapAround(map, {kSession, 0}, 20)->points[0].tracker_ids, ElementsAre(7));
  for (int64_t k = 1; k <= 60; ++k) log.Add(k, {}, {});
  EXPECT_THAT(log.LocalMapAround(map, {kSession, 0}, 20)->points[0].tracker_ids, IsEmpty());
}

}  // namespace
}  // namespace plslam::vo
