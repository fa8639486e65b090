// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/map_pose_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <utility>

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
      point.id = LandmarkId(next_point++);
      point.observations = {{10 * i, k}, {10 * (i + 1), 200 + k}};
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

TEST(MapPoseGraph, PairWithSeveralReasonsHasOneEdge) {
  const MapPoseGraph result = PoseGraphOf(Corridor(5));
  EXPECT_EQ(result.keyframe_ids, (std::vector<KeyframeId>{0, 10, 20, 30, 40}));
  EXPECT_EQ(result.problem.edges.size(), 4U);
  EXPECT_EQ(Pairs(result.problem), (std::set<std::pair<int, int>>{{0, 1}, {1, 2}, {2, 3}, {3, 4}}));
  EXPECT_TRUE(result.problem.poses[0].fixed);
  EXPECT_FALSE(result.problem.poses[1].fixed);
  for (const PoseGraphEdge& edge : result.problem.edges) {
    EXPECT_FALSE(edge.robust);
    EXPECT_NEAR(edge.T_a_b.translation().x(), 1.0, 1e-12);
    EXPECT_NEAR(edge.information(0, 0), 1.2 / std::pow(0.02 * 1.05, 2), 1e-3);
  }
}

TEST(MapPoseGraph, KeyframesFarApartThatShareLandmarksAreJoined) {
  Map map = Corridor(5);
  for (int k = 0; k < 100; ++k) {
    MapPoint point;
    point.id = 10'000 + k;
    point.observations = {{0, 400 + k}, {40, 400 + k}};
    map.Put(point);
  }
  const MapPoseGraph result = PoseGraphOf(map);
  EXPECT_TRUE(Pairs(result.problem).contains({0, 4}));
  // Drift depends on the distance, and on the number of landmarks that constrain the relative pose.
  const auto sigma_m = [&](int a) {
    const auto edge = std::find_if(result.problem.edges.begin(), result.problem.edges.end(),
                                   [a](const PoseGraphEdge& e) { return e.a == a && e.b == 4; });
    return 1.0 / std::sqrt(edge->information(0, 0));
  };
  EXPECT_NEAR(sigma_m(3), 0.02 * 1.05 / std::sqrt(1.2), 1e-6);
  EXPECT_NEAR(sigma_m(0), 0.02 * 4.05, 1e-6);
}

TEST(MapPoseGraph, ALoopIsAsCertainAsItWasMeasured) {
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
  const MapPoseGraph result = PoseGraphOf(map);
  ASSERT_EQ(result.keyframe_ids, (std::vector<KeyframeId>{0, 10, 30, 40}));
  const auto closed = std::find_if(result.problem.edges.begin(), result.problem.edges.end(),
                                   [](const PoseGraphEdge& edge) { return edge.a == 0 && edge.b == 3; });
  ASSERT_NE(closed, result.problem.edges.end());
  EXPECT_NEAR(closed->information(0, 0), 1e4, 1e-6);
  // The map has been adjusted to it since.
  EXPECT_NEAR(closed->T_a_b.translation().x(), 4.0, 1e-12);
  EXPECT_FALSE(closed->robust);
}

TEST(MapPoseGraph, AMapWithoutLoopsIsAtItsMinimum) {
  const MapPoseGraph result = PoseGraphOf(Corridor(8));
  const PoseGraphResult solved = OptimisePoseGraph(result.problem, PoseGraphOptions());
  ASSERT_TRUE(solved.ok) << solved.reason;
  EXPECT_LT(solved.chi2_before, 1e-20);
}

TEST(MapPoseGraph, NothingAndOneKeyframe) {
  EXPECT_TRUE(PoseGraphOf(Map()).problem.poses.empty());
  const MapPoseGraph one = PoseGraphOf(Corridor(1));
  EXPECT_EQ(one.problem.poses.size(), 1U);
  EXPECT_FALSE(OptimisePoseGraph(one.problem, PoseGraphOptions()).ok);
}

double Sigma_m(const std::map<KeyframeId, Matrix6d>& covariances, KeyframeId id) {
  return std::sqrt(covariances.at(id).topLeftCorner<3, 3>().trace());
}

TEST(MapPoseGraph, CovariancesGrowAlongThePathUntilALoop) {
  Map map = Corridor(41);
  const auto before = CovariancesAround(0, map);
  ASSERT_EQ(before.size(), 40U);
  EXPECT_LT(Sigma_m(before, 200), Sigma_m(before, 400));
  LoopEdge loop;
  loop.old_keyframe_id = 0;
  loop.keyframe_id = 400;
  loop.T_old_kf = map.FindKeyframe(400)->T_w_kf;
  loop.covariance = 1e-6 * Matrix6d::Identity();
  map.Add(loop);
  const auto after = CovariancesAround(400, map);
  EXPECT_LT(Sigma_m(after, 400), 0.002);
  EXPECT_LT(Sigma_m(after, 200), 0.8 * Sigma_m(before, 200));
  EXPECT_GT(Sigma_m(after, 200), 5.0 * Sigma_m(after, 400));
}

TEST(MapPoseGraph, CovariancesIncludeTheFirstKeyframe) {
  Map map = Corridor(5);
  map.SetPose(0, map.FindKeyframe(0)->T_w_kf, Matrix6d::Identity());
  EXPECT_GT(Sigma_m(CovariancesAround(40, map), 10), std::sqrt(3.0));
}

// A correction of a large map must not wait for them.
TEST(MapPoseGraph, TimeForCovariancesOfAThousandKeyframes) {
  const Map map = Corridor(1300);
  const auto begin = std::chrono::steady_clock::now();
  const auto covariances = CovariancesAround(0, map);
  const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(covariances.size(), 1299U);
  RecordProperty("ms", std::to_string(1e3 * s));
  EXPECT_LT(s, 3.0) << "0.05 s on an idle machine";
}

}  // namespace
}  // namespace plslam
