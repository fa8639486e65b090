// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/loop_edges.h"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_graph.h"
#include "mapping_process/insertion/culling.h"

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

/// Two sessions, keyframes 0 to 4 and 5 to 9, joined by the loop alone.
class RemovedEndOfALoop : public testing::Test {
 protected:
  RemovedEndOfALoop() {
    for (int id = 0; id < 10; ++id) {
      MapKeyframe keyframe;
      keyframe.id = id;
      keyframe.name = {id < 5 ? 5 : 6, id % 5};
      keyframe.T_w_kf = PoseOf(id);
      if (id % 5 > 0) {
        keyframe.previous_id = keyframe.parent_id = id - 1;
        keyframe.T_prevkf_kf = PoseOf(id - 1).Inverse() * PoseOf(id);
        // Each motion is known a little better than the one before.
        keyframe.relative_covariance = (1e-4 - 1e-6 * id) * Matrix6d::Identity();
      }
      map_.Put(keyframe);
      features_[keyframe.id] = StereoFeatures();
    }
    map_.Add(Loop().edges[0]);
  }

  bool IsConnected() const {
    const KeyframeId any = map_.keyframes().begin()->first;
    return MapGraph(map_).Component(any, MapGraph::Edges::kKnown).size() == map_.keyframes().size();
  }

  Map map_;
  KeyframeFeatures features_;
};

TEST_F(RemovedEndOfALoop, LoopMovesToTheBetterKnownNeighbour) {
  TakeOut(7, features_, map_);
  ASSERT_EQ(map_.loops().size(), 1U);
  EXPECT_EQ(map_.loops()[0].old_keyframe_id, 2);
  EXPECT_EQ(map_.loops()[0].keyframe_id, 8);
  TakeOut(2, features_, map_);
  ASSERT_EQ(map_.loops().size(), 1U);
  const LoopEdge& loop = map_.loops()[0];
  EXPECT_EQ(loop.old_keyframe_id, 3);
  EXPECT_EQ(loop.keyframe_id, 8);
  EXPECT_NEAR(ErrorOf(loop).translation().norm(), ErrorOf(Loop().edges[0]).translation().norm(), 1e-9);
  EXPECT_EQ(loop.n_points, 80);
  // The slow way: 3 to 2, then the loop, then 7 to 8.
  const SE3 T_2_3 = PoseOf(2).Inverse() * PoseOf(3);
  const SE3 T_7_8 = PoseOf(7).Inverse() * PoseOf(8);
  const Matrix6d to_2 = InverseCovariance(T_2_3, (1e-4 - 3e-6) * Matrix6d::Identity());
  const Matrix6d to_7 = ComposeCovariance(to_2, Loop().edges[0].T_old_kf, Loop().edges[0].covariance);
  const Matrix6d to_8 = ComposeCovariance(to_7, T_7_8, (1e-4 - 8e-6) * Matrix6d::Identity());
  EXPECT_LT((loop.covariance - to_8).norm(), 1e-9 * to_8.norm()) << loop.covariance << "\n\n" << to_8;
}

TEST_F(RemovedEndOfALoop, SessionsStayConnected) {
  for (const int id : {7, 8, 2, 9, 6, 0, 1, 3, 5}) {
    TakeOut(id, features_, map_);
    EXPECT_TRUE(IsConnected()) << id;
    EXPECT_EQ(map_.loops().size(), id == 5 ? 0U : 1U) << id;
  }
}

// A session that ends between two others connects them; otherwise its loops end with it.
TEST_F(RemovedEndOfALoop, SessionEnds) {
  for (const auto& [parent, n_loops] : {std::pair(-1, 1U), std::pair(8, 1U), std::pair(3, 0U)}) {
    MapKeyframe alone;
    alone.id = 10;
    alone.name = {7, 0};
    alone.parent_id = parent;
    alone.T_w_kf = PoseOf(10);
    Map map = map_;
    map.RemoveKeyframe(7);
    map.Put(alone);
    LoopEdge loop{1, 10, PoseOf(1).Inverse() * PoseOf(10), 1e-4 * Matrix6d::Identity(), 30, 0};
    map.Add(loop);
    loop.old_keyframe_id = parent == 8 ? 2 : 6;
    if (parent == 3) loop.old_keyframe_id = 0;
    loop.T_old_kf = PoseOf(loop.old_keyframe_id).Inverse() * PoseOf(10);
    map.Add(loop);
    ASSERT_EQ(map.loops().size(), 2U);
    const size_t connected = MapGraph(map).Component(1, MapGraph::Edges::kKnown).size();
    TakeOut(10, features_, map);
    EXPECT_EQ(map.loops().size(), n_loops) << parent;
    EXPECT_EQ(MapGraph(map).Component(1, MapGraph::Edges::kKnown).size(), connected - 1) << parent;
  }
}

TEST_F(RemovedEndOfALoop, MeasuredLoopIsKeptInstead) {
  LoopEdge other = Loop().edges[0];
  other.keyframe_id = 8;
  other.n_points = 50;
  map_.Add(other);
  TakeOut(7, features_, map_);
  ASSERT_EQ(map_.loops().size(), 1U);
  EXPECT_EQ(map_.loops()[0].n_points, 50);
}

}  // namespace
}  // namespace plslam::mapping
