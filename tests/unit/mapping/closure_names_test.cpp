// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/corrections/closure_check.h"

#include <gmock/gmock.h>

#include <vector>

#include "loop_process/keyframe_memory.h"

namespace plslam::mapping {
namespace {

using testing::ElementsAre;

SE3 PoseOf(int64_t i) {
  Vector6d twist;
  twist << 0.3, -0.2, 0.1, 0.02, 0.01, -0.05;
  return SE3::Exp(static_cast<double>(i) * twist);
}

Map MapOf(const std::vector<NamedKeyframe>& names) {
  Map map;
  for (const NamedKeyframe& named : names) {
    MapKeyframe keyframe;
    keyframe.id = named.keyframe_id;
    keyframe.name = named.name;
    keyframe.T_w_kf = PoseOf(static_cast<int>(named.keyframe_id.value));
    map.Put(keyframe);
  }
  return map;
}

/// Two keyframes of a tracker that was killed, and then the first one of its replacement.
Map Before() { return MapOf({{0, {7, 0}}, {1, {7, 1}}, {2, {8, 0}}}); }

/// The same, received again in another order.
Map After() { return MapOf({{0, {7, 0}}, {1, {8, 0}}, {2, {7, 1}}}); }

LoopClosure ClosureOn(const Map& map) {
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.map_version = {{}, 5, 31};
  closure.edges.push_back({1, 2, PoseOf(4), 1e-4 * Matrix6d::Identity(), 80, 9});
  closure.edges.back().covariance(0, 0) = 0.5;
  for (int id = 0; id < 3; ++id) closure.poses.push_back({id, PoseOf(10 + id)});
  closure.points = {{3, 4}};
  closure.lines = {{5, 6}};
  closure.names = loop::NamesIn(map, closure);
  return closure;
}

SE3 PoseOf(const LoopClosure& closure, KeyframeId id) {
  for (const CorrectedPose& pose : closure.poses) {
    if (pose.keyframe_id == id) return pose.T_w_kf;
  }
  return {};
}

TEST(ClosureNames, NamesAllKeyframesInTheClosure) {
  LoopClosure closure = ClosureOn(Before());
  EXPECT_THAT(closure.names,
              ElementsAre(NamedKeyframe{0, {7, 0}}, NamedKeyframe{1, {7, 1}}, NamedKeyframe{2, {8, 0}}));
  closure.poses.clear();
  EXPECT_THAT(loop::NamesIn(Before(), closure), ElementsAre(NamedKeyframe{1, {7, 1}}, NamedKeyframe{2, {8, 0}}));
}

TEST(ClosureNames, UnchangedOnItsOwnMap) {
  const LoopClosure closure = ClosureOn(Before());
  const LoopClosure here = InIdsOf(Before(), closure);
  EXPECT_EQ(here.names, closure.names);
  EXPECT_EQ(here.points, closure.points);
  EXPECT_EQ(here.lines, closure.lines);
  EXPECT_EQ(here.map_version, closure.map_version);
  ASSERT_EQ(here.poses.size(), 3U);
  for (int id = 0; id < 3; ++id) EXPECT_EQ(PoseOf(here, id).translation(), PoseOf(10 + id).translation());
  ASSERT_EQ(here.edges.size(), 1U);
  EXPECT_EQ(here.edges[0].covariance, closure.edges[0].covariance);
}

// A live map that was rebuilt from the same keyframes: its landmarks have other ids, and its versions start again.
TEST(ClosureNames, OtherMapWithSameKeyframesDropsPairs) {
  LoopClosure closure = ClosureOn(Before());
  closure.poses.push_back({77, PoseOf(9)});
  const LoopClosure here = InIdsOf(Before(), closure, MapIds::kOthers);
  EXPECT_TRUE(here.points.empty() && here.lines.empty());
  EXPECT_EQ(here.names, closure.names);
  EXPECT_EQ(here.edges.size(), 1U);
  EXPECT_EQ(here.poses.size(), 3U) << "the fourth bears no name";
}

// A correction that exchanged keyframes 1 and 2 would put each at the pose of the other.
TEST(ClosureNames, KeyframesAreFoundInARebuiltMap) {
  const LoopClosure closure = ClosureOn(Before());
  const LoopClosure here = InIdsOf(After(), closure);
  EXPECT_EQ(PoseOf(here, 0).translation(), PoseOf(10).translation());
  EXPECT_EQ(PoseOf(here, 1).translation(), PoseOf(12).translation()) << "session 8";
  EXPECT_EQ(PoseOf(here, 2).translation(), PoseOf(11).translation()) << "session 7";
  EXPECT_THAT(here.names, ElementsAre(NamedKeyframe{0, {7, 0}}, NamedKeyframe{1, {8, 0}}, NamedKeyframe{2, {7, 1}}));
  EXPECT_TRUE(here.points.empty()) << "landmarks have other ids there";
  EXPECT_TRUE(here.lines.empty());
}

TEST(ClosureNames, EdgeIsInvertedIfItsEndsChangeOrder) {
  const LoopClosure closure = ClosureOn(Before());
  const LoopClosure here = InIdsOf(After(), closure);
  ASSERT_EQ(here.edges.size(), 1U);
  const LoopEdge& edge = here.edges[0];
  EXPECT_EQ(edge.old_keyframe_id, 1);
  EXPECT_EQ(edge.keyframe_id, 2);
  EXPECT_LT((edge.T_old_kf * PoseOf(4)).Log().norm(), 1e-12);
  Matrix6d J;  // by differences: of an error to the right of the motion, to the right of its inverse
  for (int i = 0; i < 6; ++i) {
    const SE3 T_off = PoseOf(4) * SE3::Exp(1e-6 * Vector6d::Unit(i));
    J.col(i) = (edge.T_old_kf.Inverse() * T_off.Inverse()).Log() / 1e-6;
  }
  EXPECT_LT((edge.covariance - J * closure.edges[0].covariance * J.transpose()).norm(), 1e-5);
  EXPECT_EQ(edge.n_points, 80);
}

TEST(ClosureNames, RebuiltMapDropsMissingAndUnnamedKeyframes) {
  LoopClosure closure = ClosureOn(Before());
  closure.names.erase(closure.names.begin());
  Map map = After();
  map.RemoveKeyframe(1);  // the one that was 2
  const LoopClosure here = InIdsOf(map, closure);
  EXPECT_TRUE(here.edges.empty());
  ASSERT_EQ(here.poses.size(), 1U);
  EXPECT_EQ(here.poses[0].keyframe_id, 2);
  EXPECT_THAT(here.names, ElementsAre(NamedKeyframe{2, {7, 1}}));
}

// It was found in the milliseconds before: its edge may still be useful for the replacement of the culled keyframe.
TEST(ClosureNames, KeyframeCulledSinceChangesNothing) {
  const LoopClosure closure = ClosureOn(Before());
  Map map = Before();
  map.RemoveKeyframe(2);
  const LoopClosure here = InIdsOf(map, closure);
  EXPECT_EQ(here.edges.size(), 1U);
  EXPECT_EQ(here.poses.size(), 3U);
  EXPECT_EQ(here.points, closure.points);
  EXPECT_EQ(here.map_version, closure.map_version);
}

TEST(ClosureNames, IdReusedByAnotherKeyframeDiffers) {
  const LoopClosure closure = ClosureOn(Before());
  const LoopClosure here = InIdsOf(MapOf({{0, 7, 0}, {1, 7, 1}, {2, 9, 0}}), closure);
  EXPECT_TRUE(here.edges.empty());
  EXPECT_EQ(here.poses.size(), 2U);
  EXPECT_TRUE(here.points.empty());
}

}  // namespace
}  // namespace plslam::mapping
