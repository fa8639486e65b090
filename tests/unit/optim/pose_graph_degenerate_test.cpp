// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "core/optim/pose_graph/pose_graph.h"
#include "tests/unit/optim/pose_graph_world.h"

namespace plslam {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

PoseGraphProblem Pair() {
  PoseGraphProblem graph;
  graph.poses.resize(2);
  graph.poses[1].T_w_kf = SE3(Eigen::Quaterniond::Identity(), {0.5, 0.0, 0.0});
  graph.edges.push_back(test::MakeEdge<SE3>({}, 0, 1, SE3(Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0}), false));
  return graph;
}

void ExpectRefused(const PoseGraphProblem& graph, const std::string& part_of_reason) {
  for (const auto& [name, start] : ChoicesOf(GraphStart())) {
    PoseGraphOptions options;
    options.start = start;
    const PoseGraphResult result = OptimisePoseGraph(graph, options);
    EXPECT_FALSE(result.ok);
    EXPECT_NE(result.reason.find(part_of_reason), std::string::npos) << result.reason;
    EXPECT_EQ(result.T_w_kf.size(), graph.poses.size());
    EXPECT_EQ(result.rejected.size(), graph.edges.size());
    EXPECT_EQ(PoseGraphCovariances(graph, result).size(), graph.poses.size());
  }
}

TEST(PoseGraphDegenerate, NothingAtAll) { ExpectRefused({}, "no edge"); }

TEST(PoseGraphDegenerate, PosesWithoutEdges) {
  PoseGraphProblem graph = Pair();
  graph.edges.clear();
  ExpectRefused(graph, "no edge");
}

TEST(PoseGraphDegenerate, EdgesToMissingPoses) {
  PoseGraphProblem graph = Pair();
  graph.edges[0].b = 2;
  ExpectRefused(graph, "edge 0 from pose 0 to 2 joins a pose that is not one of the 2");
  graph.edges[0].b = -1;
  ExpectRefused(graph, "not one of the 2");
  graph.edges[0].b = 0;
  ExpectRefused(graph, "to itself");
}

TEST(PoseGraphDegenerate, ValuesThatAreNotFinite) {
  PoseGraphProblem graph = Pair();
  graph.poses[1].T_w_kf = SE3(Eigen::Quaterniond::Identity(), {kNaN, 0.0, 0.0});
  ExpectRefused(graph, "pose 1 is not finite");
  graph = Pair();
  graph.edges[0].T_a_b = SE3(Eigen::Quaterniond::Identity(), {kNaN, 0.0, 0.0});
  ExpectRefused(graph, "motion that is not finite");
  graph = Pair();
  graph.edges[0].information(3, 3) = kNaN;
  ExpectRefused(graph, "information that is not finite");
}

TEST(PoseGraphDegenerate, ValuesTooLargeToSquare) {
  PoseGraphProblem graph = Pair();
  graph.poses[1].T_w_kf = SE3(Eigen::Quaterniond::Identity(), {1e300, 0.0, 0.0});
  ExpectRefused(graph, "too large");
}

TEST(PoseGraphDegenerate, InformationThatIsNotPositiveDefinite) {
  PoseGraphProblem graph = Pair();
  graph.edges[0].information(5, 5) = 0.0;
  ExpectRefused(graph, "not positive definite");
  graph.edges[0].information(5, 5) = 1.0;
  graph.edges[0].information(0, 5) = 100.0;
  ExpectRefused(graph, "not symmetric");
}

TEST(PoseGraphDegenerate, EverythingFixed) {
  PoseGraphProblem graph = Pair();
  graph.poses[0].fixed = graph.poses[1].fixed = true;
  ExpectRefused(graph, "no pose is free");
}

TEST(PoseGraphDegenerate, OneEdgeIsMetExactly) {
  const PoseGraphResult result = OptimisePoseGraph(Pair(), PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  EXPECT_LT(result.chi2_after, 1e-15);
  EXPECT_EQ(result.T_w_kf[0].translation().norm(), 0.0);
  EXPECT_NEAR(result.T_w_kf[1].translation().x(), 1.0, 1e-9);
}

TEST(PoseGraphDegenerate, AllPosesAndEdgesAreIdentity) {
  PoseGraphProblem graph;
  graph.poses.resize(10);
  for (int i = 1; i < 10; ++i) graph.edges.push_back(test::MakeEdge<SE3>({}, i - 1, i, SE3(), i % 2 == 0));
  for (const auto& [name, start] : ChoicesOf(GraphStart())) {
    PoseGraphOptions options;
    options.start = start;
    const PoseGraphResult result = OptimisePoseGraph(graph, options);
    ASSERT_TRUE(result.ok) << result.reason;
    EXPECT_EQ(result.chi2_after, 0.0);
    for (const SE3& pose : result.T_w_kf) EXPECT_EQ(pose.translation().norm(), 0.0);
  }
}

TEST(PoseGraphDegenerate, FirstPoseOfEachPartIsFixedByDefault) {
  PoseGraphProblem graph;
  graph.poses.resize(7);
  for (int i = 0; i < 7; ++i) {
    graph.poses[i].T_w_kf = SE3(Eigen::Quaterniond::Identity(), {10.0 * i, 1.0, 0.0});
  }
  graph.poses[4].fixed = true;
  const SE3 step(Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0});
  graph.edges = {test::MakeEdge<SE3>({}, 0, 1, step, false), test::MakeEdge<SE3>({}, 5, 2, step, false),
                 test::MakeEdge<SE3>({}, 3, 4, step, false)};
  for (const GraphStart start : {GraphStart::kGiven, GraphStart::kChordal}) {
    PoseGraphOptions options;
    options.start = start;
    const PoseGraphResult result = OptimisePoseGraph(graph, options);
    ASSERT_TRUE(result.ok) << result.reason;
    const double expected[] = {0.0, 1.0, 20.0, 39.0, 40.0, 19.0, 60.0};
    for (int i = 0; i < 7; ++i)
      EXPECT_NEAR(result.T_w_kf[i].translation().x(), expected[i], 1e-6) << NameOf(start) << i;
    for (const int constant : {0, 2, 4, 6}) {
      EXPECT_EQ(result.T_w_kf[constant].translation(), graph.poses[constant].T_w_kf.translation());
    }
  }
}

TEST(PoseGraphDegenerate, InformationOfCovariances) {
  Matrix6d covariance = Matrix6d::Identity();
  covariance(2, 2) = 4.0;
  ASSERT_TRUE(InformationFromCovariance(covariance).has_value());
  EXPECT_DOUBLE_EQ((*InformationFromCovariance(covariance))(2, 2), 0.25);
  covariance(2, 2) = 0.0;
  EXPECT_FALSE(InformationFromCovariance(covariance).has_value());
  covariance(2, 2) = -1.0;
  EXPECT_FALSE(InformationFromCovariance(covariance).has_value());
  covariance(2, 2) = kNaN;
  EXPECT_FALSE(InformationFromCovariance(covariance).has_value());
}

}  // namespace
}  // namespace plslam
