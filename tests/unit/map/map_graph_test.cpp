// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

namespace plslam {
namespace {

using testing::ElementsAre;

/// Keyframes in a row, a metre apart; at `lost`, odometry does not know the step from the previous keyframe.
Map Row(int keyframes, int lost = -1) {
  Map map;
  for (int i = 0; i < keyframes; ++i) {
    MapKeyframe keyframe;
    keyframe.name.number = i;
    keyframe.id = KeyframeId(keyframe.name.number);
    keyframe.previous_id = keyframe.parent_id = i - 1;
    keyframe.T_prevkf_kf = SE3(Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0});
    keyframe.T_w_kf = SE3(Eigen::Quaterniond::Identity(), {1.0 * i, 0.0, 0.0});
    keyframe.relative_covariance = (i == lost ? 1.0 : 1e-6) * Matrix6d::Identity();
    map.Put(keyframe);
  }
  return map;
}

void Share(int a, int b, int landmarks, Map& map) {
  for (int k = 0; k < landmarks; ++k) {
    MapPoint point;
    point.id = 1000 * (a + 1) + 100'000 * (b + 1) + k;
    point.observations = {{a, 2000 * b + k}, {b, 2000 * a + k}};
    map.Put(point);
  }
}

std::vector<std::pair<int64_t, int64_t>> Pairs(const MapGraph& graph) {
  std::vector<std::pair<int64_t, int64_t>> pairs;
  for (const MapEdge& edge : graph.edges()) pairs.emplace_back(edge.a.value, edge.b.value);
  return pairs;
}

TEST(MapGraph, PairWithSeveralReasonsIsOneEdge) {
  Map map = Row(4);
  Share(0, 1, Map::kEssential, map);
  Share(0, 3, Map::kEssential, map);
  Share(1, 3, Map::kEssential - 1, map);
  const MapGraph graph(map);
  EXPECT_THAT(Pairs(graph), ElementsAre(std::pair(0, 1), std::pair(0, 3), std::pair(1, 2), std::pair(2, 3)));
  EXPECT_TRUE(graph.edges()[0].odometry && graph.edges()[0].known);
  EXPECT_EQ(graph.edges()[0].shared, Map::kEssential);
  EXPECT_FALSE(graph.edges()[1].odometry);
  EXPECT_TRUE(graph.edges()[1].known);
}

TEST(MapGraph, StepWhileLostConnectsButIsNotKnown) {
  Map map = Row(4, 2);
  const MapGraph graph(map);
  EXPECT_FALSE(graph.edges()[1].known);
  EXPECT_THAT(graph.Component(0, MapGraph::Edges::kKnown), ElementsAre(0, 1));
  EXPECT_THAT(graph.Component(3, MapGraph::Edges::kKnown), ElementsAre(2, 3));
  EXPECT_THAT(graph.Component(3, MapGraph::Edges::kAll), ElementsAre(0, 1, 2, 3));
  // Landmarks that both sides observe determine the step after all.
  Share(1, 2, Map::kParent, map);
  EXPECT_EQ(MapGraph(map).Component(0, MapGraph::Edges::kKnown).size(), 4U);
}

TEST(MapGraph, LoopConnectsAndTheNewestIsUsed) {
  Map map = Row(4, 2);
  LoopEdge loop;
  loop.old_keyframe_id = 3;
  loop.keyframe_id = 0;
  map.Add(loop);
  map.Add(loop);
  const MapGraph graph(map);
  ASSERT_THAT(Pairs(graph), ElementsAre(std::pair(0, 1), std::pair(0, 3), std::pair(1, 2), std::pair(2, 3)));
  EXPECT_EQ(graph.edges()[1].loop, 1);
  EXPECT_EQ(graph.Component(1, MapGraph::Edges::kKnown).size(), 4U);
}

TEST(MapGraph, EdgesToRemovedKeyframesAreOmitted) {
  Map map = Row(3);
  LoopEdge loop;
  loop.old_keyframe_id = 0;
  loop.keyframe_id = 2;
  map.Add(loop);
  map.RemoveKeyframe(1);
  const MapGraph graph(map);
  for (const MapEdge& edge : graph.edges()) EXPECT_TRUE(edge.a == 0 && edge.b == 2);
  EXPECT_THAT(MapGraph(Map()).Component(7, MapGraph::Edges::kAll), ElementsAre(7));
}

}  // namespace
}  // namespace plslam
