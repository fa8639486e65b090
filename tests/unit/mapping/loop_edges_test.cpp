// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/corrections/loop_edges.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace plslam::mapping {
namespace {

SE3 At(double x_m, double yaw_rad) {
  Vector6d twist;
  twist << 0.0, 0.0, 0.0, 0.0, yaw_rad, 0.0;
  return SE3(SE3::Exp(twist).rotation(), {x_m, 0.3 * x_m, 0.0});
}

/// Keyframes 0 to 9, a metre from one to the next.
SE3 PoseOf(KeyframeId id) { return At(static_cast<double>(id.value), 0.1 * static_cast<double>(id.value)); }

Map MapWithout(const std::vector<KeyframeId>& culled) {
  Map map;
  for (int id = 0; id < 10; ++id) {
    MapKeyframe keyframe;
    keyframe.id = id;
    keyframe.name.session = 5;
    keyframe.name.number = 2 * id;
    keyframe.T_w_kf = PoseOf(id);
    if (std::find(culled.begin(), culled.end(), keyframe.id) == culled.end()) map.Put(keyframe);
  }
  return map;
}

/// A loop between 2 and 7, off by a little from where the correction puts them.
LoopClosure Loop() {
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  for (int id = 0; id < 10; ++id) {
    closure.poses.push_back({id, PoseOf(id)});
    closure.names.push_back({id, {5, 2 * id}});
  }
  Matrix6d covariance = 1e-4 * Matrix6d::Identity();
  covariance(0, 0) = 4e-4;
  closure.edges.push_back({2, 7, PoseOf(2).Inverse() * PoseOf(7) * At(0.01, 0.0), covariance, 80, 9});
  return closure;
}

/// Returns the difference of the edge to the relative pose of its keyframes.
SE3 ErrorOf(const LoopEdge& edge) {
  return (PoseOf(edge.old_keyframe_id).Inverse() * PoseOf(edge.keyframe_id)).Inverse() * edge.T_old_kf;
}

TEST(LoopEdges, UnchangedBetweenKeyframesOfTheMap) {
  const auto edges = EdgesInMap(Loop(), MapWithout({}));
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_EQ(edges[0].old_keyframe_id, 2);
  EXPECT_EQ(edges[0].keyframe_id, 7);
  EXPECT_EQ(edges[0].covariance, Loop().edges[0].covariance);
}

TEST(LoopEdges, CulledEndsMoveToTheirNeighbours) {
  for (const auto& [culled, old_id, id] : std::vector<std::tuple<std::vector<KeyframeId>, KeyframeId, KeyframeId>>{
           {{2, 3}, 1, 7}, {{7, 6}, 2, 8}, {{2, 3, 7, 6}, 1, 8}, {{2, 0, 1, 3, 4, 5, 6}, 7, 7}}) {
    const auto edges = EdgesInMap(Loop(), MapWithout(culled));
    if (old_id == id) {
      EXPECT_TRUE(edges.empty()) << "both ends are one";
      continue;
    }
    ASSERT_EQ(edges.size(), 1U);
    EXPECT_EQ(edges[0].old_keyframe_id, old_id);
    EXPECT_EQ(edges[0].keyframe_id, id);
    EXPECT_NEAR(ErrorOf(edges[0]).translation().norm(), ErrorOf(Loop().edges[0]).translation().norm(), 1e-9);
    EXPECT_NEAR(ErrorOf(edges[0]).Log().tail<3>().norm(), 0.0, 1e-9);
    // The metre between the two ends of a turned covariance makes it no smaller.
    EXPECT_GE(edges[0].covariance.trace(), Loop().edges[0].covariance.trace() - 1e-12);
    EXPECT_EQ(edges[0].n_points, 80);
  }
}

TEST(LoopEdges, CulledEndWithoutPoseOrNameDropsTheEdge) {
  LoopClosure closure = Loop();
  closure.names[2].name.session = 6;
  EXPECT_TRUE(EdgesInMap(closure, MapWithout({2})).empty());
  closure = Loop();
  closure.poses.erase(closure.poses.begin() + 2);
  EXPECT_TRUE(EdgesInMap(closure, MapWithout({2})).empty());
  EXPECT_TRUE(EdgesInMap(Loop(), Map()).empty());
}

TEST(LoopEdges, ReversedTwiceIsTheSame) {
  const LoopEdge edge = Loop().edges[0];
  const LoopEdge reversed = Reversed(edge);
  EXPECT_EQ(reversed.old_keyframe_id, 7);
  EXPECT_NEAR((reversed.T_old_kf * edge.T_old_kf).Log().norm(), 0.0, 1e-12);
  const LoopEdge again = Reversed(reversed);
  EXPECT_NEAR((again.covariance - edge.covariance).norm(), 0.0, 1e-12);
  EXPECT_NEAR((again.T_old_kf.Inverse() * edge.T_old_kf).Log().norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace plslam::mapping
