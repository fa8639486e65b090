#include "tools/pose_graph/pose_graph_of_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>

#include <Eigen/LU>

namespace plslam {
namespace {

// Keyframes on a straight line, one a metre, each with 120 points that the next one sees too.
Map Corridor(int keyframes) {
  Map map;
  for (int i = 0; i < keyframes; ++i) {
    MapKeyframe keyframe;
    keyframe.id = 10 * i;
    keyframe.T_w_kf = SE3(Eigen::Quaterniond::Identity(), {1.0 * i, 0.0, 0.0});
    keyframe.previous_id = keyframe.parent_id = i == 0 ? -1 : 10 * (i - 1);
    keyframe.T_prevkf_kf = SE3(Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0});
    keyframe.relative_covariance = 1e-4 * Matrix6d::Identity();
    map.Put(keyframe);
  }
  int64_t next_point = 0;
  for (int i = 0; i + 1 < keyframes; ++i) {
    for (int k = 0; k < 120; ++k) {
      MapPoint point;
      point.id = next_point++;
      point.sights = {{10 * i, k}, {10 * (i + 1), 200 + k}};
      map.Put(point);
    }
  }
  return map;
}

std::set<std::pair<int, int>> Pairs(const PoseGraphProblem& graph) {
  std::set<std::pair<int, int>> pairs;
  for (const PoseGraphEdge& edge : graph.edges) pairs.emplace(edge.a, edge.b);
  return pairs;
}

TEST(PoseGraphOfMap, EachPairIsJoinedOnceHoweverManyReasonsThereAre) {
  const MapPoseGraph result = PoseGraphOf(Corridor(5));
  EXPECT_EQ(result.keyframe_ids, (std::vector<int64_t>{0, 10, 20, 30, 40}));
  EXPECT_EQ(result.graph.edges.size(), 4U);
  EXPECT_EQ(Pairs(result.graph), (std::set<std::pair<int, int>>{{0, 1}, {1, 2}, {2, 3}, {3, 4}}));
  EXPECT_TRUE(result.graph.poses[0].fixed);
  EXPECT_FALSE(result.graph.poses[1].fixed);
  for (const PoseGraphEdge& edge : result.graph.edges) {
    EXPECT_FALSE(edge.robust);
    EXPECT_NEAR(edge.T_a_b.translation().x(), 1.0, 1e-12);
    EXPECT_NEAR(edge.information(0, 0), 1e4, 1e-6);
  }
}

TEST(PoseGraphOfMap, KeyframesFarApartThatShareLandmarksAreJoined) {
  Map map = Corridor(5);
  for (int k = 0; k < 100; ++k) {
    MapPoint point;
    point.id = 10'000 + k;
    point.sights = {{0, 400 + k}, {40, 400 + k}};
    map.Put(point);
  }
  const MapPoseGraph result = PoseGraphOf(map);
  EXPECT_TRUE(Pairs(result.graph).contains({0, 4}));
  for (const PoseGraphEdge& edge : result.graph.edges) {
    if (edge.b != 4) continue;
    // Two edges share what odometry knew; along the corridor its four steps add up.
    const double steps = edge.a == 0 ? 4.0 : 1.0;
    EXPECT_NEAR(edge.information.inverse()(0, 0), 2.0 * steps * 1e-4, 1e-9) << edge.a;
  }
}

TEST(PoseGraphOfMap, LandmarksSeenAgainAfterALongWayAreNotAsUncertainAsTheWay) {
  Map map = Corridor(40);
  for (int k = 0; k < 100; ++k) {
    MapPoint point;
    point.id = 10'000 + k;
    point.sights = {{0, 400 + k}, {390, 400 + k}};
    map.Put(point);
  }
  const MapPoseGraph result = PoseGraphOf(map);
  const auto closing = std::find_if(result.graph.edges.begin(), result.graph.edges.end(),
                                    [](const PoseGraphEdge& edge) { return edge.a == 0 && edge.b == 39; });
  ASSERT_NE(closing, result.graph.edges.end());
  // 100 landmarks where odometry had 120, and another edge to the same keyframe.
  EXPECT_NEAR(closing->information(0, 0), 1e4 / 1.2 / 2.0, 1e-6);
}

TEST(PoseGraphOfMap, LoopsAreRobustAndThoseOfRemovedKeyframesAreLeftOut) {
  Map map = Corridor(5);
  LoopEdge loop;
  loop.old_keyframe_id = 0;
  loop.keyframe_id = 40;
  loop.T_old_kf = SE3(Eigen::Quaterniond::Identity(), {3.9, 0.0, 0.0});
  loop.covariance = 1e-4 * Matrix6d::Identity();
  map.Add(loop);
  loop.old_keyframe_id = 20;
  map.Add(loop);
  map.RemoveKeyframe(20);
  const MapPoseGraph result = PoseGraphOf(map, {loop, map.loops()[0]});
  ASSERT_EQ(result.graph.edges.size(), 5U);  // three in a row, and one loop twice
  EXPECT_TRUE(result.graph.edges[3].robust && result.graph.edges[4].robust);
  EXPECT_EQ(result.graph.edges[4].b, 3);
  const PoseGraphResult solved = OptimisePoseGraph(result.graph, PoseGraphOptions());
  ASSERT_TRUE(solved.ok) << solved.reason;
  EXPECT_LT(solved.T_w_kf[3].translation().x(), 4.0);
}

TEST(PoseGraphOfMap, AMapWithoutLoopsIsAtItsMinimum) {
  const MapPoseGraph result = PoseGraphOf(Corridor(8));
  const PoseGraphResult solved = OptimisePoseGraph(result.graph, PoseGraphOptions());
  ASSERT_TRUE(solved.ok) << solved.reason;
  EXPECT_LT(solved.chi2_before, 1e-20);
}

TEST(PoseGraphOfMap, NothingAndOneKeyframe) {
  EXPECT_TRUE(PoseGraphOf(Map()).graph.poses.empty());
  const MapPoseGraph one = PoseGraphOf(Corridor(1));
  EXPECT_EQ(one.graph.poses.size(), 1U);
  EXPECT_FALSE(OptimisePoseGraph(one.graph, PoseGraphOptions()).ok);
}

}  // namespace
}  // namespace plslam
