// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/pose_graph_chain.h"

#include <gtest/gtest.h>

#include "tests/unit/optim/pose_graph_world.h"

namespace plslam::pose_graph {
namespace {

SE2 Step(double x) { return SE2(0.0, {x, 0.0}); }

TEST(ChainedPoses, OdometryComesBeforeOtherEdges) {
  PoseGraph<SE2> graph;
  graph.poses.resize(4);
  graph.poses[0].T_w_kf = SE2(0.0, {5.0, 0.0});
  graph.edges = {test::MakeEdge<SE2>({}, 0, 3, Step(100.0), true), test::MakeEdge<SE2>({}, 0, 1, Step(1.0), false),
                 test::MakeEdge<SE2>({}, 2, 1, Step(-1.0), false), test::MakeEdge<SE2>({}, 2, 3, Step(1.0), false)};
  const auto poses = ChainedPoses(graph);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(poses[i].translation().x(), 5.0 + i, 1e-12) << i;
}

TEST(ChainedPoses, OthersAreChainedToTheNearestKnownPose) {
  PoseGraph<SE2> graph;
  graph.poses.resize(6);
  for (int i = 1; i < 5; ++i) graph.edges.push_back(test::MakeEdge<SE2>({}, i - 1, i, Step(1.0), false));
  graph.poses[3].T_w_kf = SE2(0.0, {50.0, 0.0});
  graph.poses[5].T_w_kf = SE2(0.0, {7.0, 0.0});
  const auto poses = ChainedPoses(graph, {false, false, false, true, false, false});
  const double expected[] = {47.0, 48.0, 49.0, 50.0, 51.0, 7.0};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(poses[i].translation().x(), expected[i], 1e-12) << i;
}

TEST(ChainedPoses, WithoutNoiseTheyAreTheTruth) {
  auto world = test::MakePoseGraphWorld<SE3>({.poses = 50, .lap = 10});
  for (auto& edge : world.graph.edges) edge.T_a_b = world.truth[edge.a].Inverse() * world.truth[edge.b];
  EXPECT_LT(test::LargestError_m(ChainedPoses(world.graph), world.truth), 1e-9);
}

TEST(ChainedPoses, Nothing) { EXPECT_TRUE(ChainedPoses(PoseGraph<SE3>()).empty()); }

}  // namespace
}  // namespace plslam::pose_graph
