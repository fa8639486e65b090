// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_rejection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/optim/pose_graph_world.h"

namespace plslam {
namespace {

using test::LargestError_m;
using test::MakePoseGraphWorld;

int Rejected(const PoseGraphResult& result) {
  return static_cast<int>(std::count(result.rejected.begin(), result.rejected.end(), true));
}

SE3 Moved(double x, double yaw) {
  Vector6d step;
  step << x, 0.5 * x, 0.0, 0.0, 0.0, yaw;
  return SE3::Exp(step);
}

TEST(PoseGraphRejection, GainsEqualASolveWithoutTheEdge) {
  const auto world = MakePoseGraphWorld<SE3>({.poses = 60, .lap = 20, .sigma_m = 0.01, .sigma_rad = 0.002});
  PoseGraphOptions options;
  options.function_tolerance = 1e-14;
  options.rejection_chi2 = 1e12;
  const auto all = OptimisePoseGraph(world.graph, options);
  ASSERT_TRUE(all.ok);
  const auto gains = DeletionGains(world.graph, all.T_w_kf, all.rejected);
  int robust = 0;
  for (size_t i = 0; i < world.graph.edges.size(); ++i) {
    if (!world.graph.edges[i].robust) {
      EXPECT_EQ(gains[i], 0.0);
      continue;
    }
    ++robust;
    PoseGraphProblem without = world.graph;
    without.edges.erase(without.edges.begin() + static_cast<std::ptrdiff_t>(i));
    const double gain = all.chi2_after - OptimisePoseGraph(without, options).chi2_after;
    EXPECT_NEAR(gains[i], gain, 0.02 * gain + 1e-3) << "edge " << i;
  }
  EXPECT_GT(robust, 5);
}

TEST(PoseGraphRejection, OneWrongLoopAmongCorrectOnesIsRejected) {
  auto world = MakePoseGraphWorld<SE3>({.poses = 120, .lap = 40});
  const auto right = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_EQ(Rejected(right), 0);
  const size_t wrong = world.graph.edges.size();
  world.graph.edges.push_back(test::MakeEdge<SE3>({}, 10, 75, Moved(2.0, 1.5), true));
  const auto result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_EQ(Rejected(result), 1);
  EXPECT_TRUE(result.rejected[wrong]);
  EXPECT_LT(LargestError_m(result.T_w_kf, right.T_w_kf), 1e-3);
}

TEST(PoseGraphRejection, ManyWrongLoopsAreRejectedNoCorrectOne) {
  auto world = MakePoseGraphWorld<SE3>({.poses = 150, .lap = 30});
  const size_t n_right = world.graph.edges.size();
  std::mt19937_64 random(4);
  for (int i = 0; i < 12; ++i) {
    const int a = static_cast<int>(random() % 60);
    const int b = 80 + static_cast<int>(random() % 60);
    world.graph.edges.push_back(test::MakeEdge<SE3>({}, a, b, Moved(0.5 * i - 3.0, 0.3 * i - 1.0), true));
  }
  const auto result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  for (size_t i = 0; i < world.graph.edges.size(); ++i) EXPECT_EQ(result.rejected[i], i >= n_right) << i;
  EXPECT_LT(LargestError_m(result.T_w_kf, world.truth), 0.3);
}

// It is contradicted only by the odometry in between, which it would distort.
TEST(PoseGraphRejection, AnOnlyLoopThatOdometryRulesOutIsRejected) {
  auto world = MakePoseGraphWorld<SE3>({.poses = 60, .lap = 1000});
  world.graph.edges.push_back(test::MakeEdge<SE3>({}, 0, 59, SE3(), true));
  const auto result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_TRUE(result.rejected.back());
  EXPECT_LT(LargestError_m(result.T_w_kf, world.truth), 1.0);
}

// It distorts everything else until next to nothing is left of its own residual.
TEST(PoseGraphRejection, OverconfidentWrongLoopIsRejected) {
  auto world = MakePoseGraphWorld<SE3>({.poses = 200, .lap = 1000});
  world.graph.edges.push_back(
      test::MakeEdge<SE3>({.sigma_m = 1e-5, .sigma_rad = 1e-6}, 20, 180, Moved(3.0, 0.3), true));
  const auto result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_TRUE(result.rejected.back());
}

TEST(PoseGraphRejection, AnOnlyLoopWithinTheDriftIsClosed) {
  auto world = MakePoseGraphWorld<SE3>({.poses = 60, .lap = 59, .reach = 1, .seed = 8});
  std::erase_if(world.graph.edges, [](const PoseGraphEdge& edge) { return edge.robust; });
  const SE3 T_0_59 = world.truth[0].Inverse() * world.truth[59];
  world.graph.edges.push_back(test::MakeEdge<SE3>({}, 0, 59, T_0_59, true));
  const auto result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_EQ(Rejected(result), 0);
  const SE3 closed = result.T_w_kf[0].Inverse() * result.T_w_kf[59];
  EXPECT_LT((closed.translation() - T_0_59.translation()).norm(), 0.02);
}

TEST(PoseGraphRejection, ALoopThatJoinsTwoPartsIsNeverRejected) {
  auto world = MakePoseGraphWorld<SE3>({.poses = 40, .lap = 1000});
  std::erase_if(world.graph.edges, [](const PoseGraphEdge& edge) { return edge.a < 20 && edge.b >= 20; });
  world.graph.edges.push_back(test::MakeEdge<SE3>({}, 3, 30, Moved(7.0, 1.0), true));
  const auto result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_EQ(Rejected(result), 0);
  const SE3 joined = result.T_w_kf[3].Inverse() * result.T_w_kf[30];
  EXPECT_LT((joined.translation() - Moved(7.0, 1.0).translation()).norm(), 1e-4);
}

TEST(PoseGraphRejection, WrongEdgesThatAreNotRobustAreKept) {
  auto world = MakePoseGraphWorld<SE3>({.poses = 60, .lap = 20});
  world.graph.edges.push_back(test::MakeEdge<SE3>({}, 0, 59, Moved(2.0, 0.5), false));
  const auto result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_FALSE(result.rejected.back());
}

}  // namespace
}  // namespace plslam
