// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <Eigen/LU>

#include "core/optim/pose_graph/pose_graph_check.h"
#include "core/optim/pose_graph/pose_graph_chordal.h"
#include "core/optim/pose_graph/pose_graph_group.h"
#include "tests/support/dense_algebra.h"
#include "tests/unit/optim/pose_graph_world.h"

namespace plslam {
namespace {

template <class Pose>
class PoseGraphTest : public testing::Test {};
using Poses = testing::Types<SE3, SE2>;
TYPED_TEST_SUITE(PoseGraphTest, Poses);

template <class Pose>
using Tangent = Eigen::Matrix<double, kPoseFreedom<Pose>, 1>;

template <class Pose>
Pose RandomPose(std::mt19937_64& random, double angle) {
  std::normal_distribution<double> normal;
  Tangent<Pose> step;
  for (int i = 0; i < step.size(); ++i) step[i] = normal(random) * (i < PoseGroup<Pose>::kDimension ? 3.0 : angle);
  return PoseGroup<Pose>::Plus(Pose(), step.data());
}

PoseGraphOptions Tight() {
  PoseGraphOptions options;
  options.max_iterations = 100;
  options.function_tolerance = 1e-14;
  return options;
}

TYPED_TEST(PoseGraphTest, DerivativesMatchDifferences) {
  using Group = PoseGroup<TypeParam>;
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const TypeParam a = RandomPose<TypeParam>(random, 1.0);
    const TypeParam measured = RandomPose<TypeParam>(random, 1.0);
    const TypeParam b = a * measured * RandomPose<TypeParam>(random, 0.4);
    const PoseEdgeError<TypeParam> error = Group::Error(measured, a, b);
    for (int k = 0; k < kPoseFreedom<TypeParam>; ++k) {
      constexpr double kStep = 1e-6;
      const Tangent<TypeParam> plus = kStep * Tangent<TypeParam>::Unit(k);
      const Tangent<TypeParam> minus = -plus;
      const Tangent<TypeParam> by_a = (Group::Error(measured, Group::Plus(a, plus.data()), b).e -
                                       Group::Error(measured, Group::Plus(a, minus.data()), b).e) /
                                      (2.0 * kStep);
      const Tangent<TypeParam> by_b = (Group::Error(measured, a, Group::Plus(b, plus.data())).e -
                                       Group::Error(measured, a, Group::Plus(b, minus.data())).e) /
                                      (2.0 * kStep);
      EXPECT_LT((by_a - error.by_a.col(k)).norm(), 1e-7) << by_a.transpose() << "\n" << error.by_a.col(k).transpose();
      EXPECT_LT((by_b - error.by_b.col(k)).norm(), 1e-7) << by_b.transpose() << "\n" << error.by_b.col(k).transpose();
    }
  }
}

TYPED_TEST(PoseGraphTest, LapsDrivenTwiceReachTheTruth) {
  const auto world = test::MakePoseGraphWorld<TypeParam>({.poses = 200, .lap = 50, .seed = 3});
  const auto result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  ASSERT_TRUE(result.ok) << result.reason;
  std::vector<TypeParam> chained;
  for (const auto& node : world.graph.poses) chained.push_back(node.T_w_kf);
  const double before = test::LargestError_m(chained, world.truth);
  const double after = test::LargestError_m(result.T_w_kf, world.truth);
  EXPECT_LT(after, before / 2.0) << before << " m before, " << after << " m after";
  EXPECT_EQ(std::count(result.rejected.begin(), result.rejected.end(), true), 0);
  // Freedom: rows of the edges less those of the free poses.
  const double freedom =
      static_cast<double>(kPoseFreedom<TypeParam> * (world.graph.edges.size() - world.graph.poses.size() + 1));
  EXPECT_NEAR(result.chi2_after / freedom, 1.0, 5.0 * std::sqrt(2.0 / freedom)) << result.chi2_after;
  EXPECT_DOUBLE_EQ(result.chi2_before, PoseGraphChi2(world.graph, chained));
  EXPECT_NEAR(result.chi2_after, PoseGraphChi2(world.graph, result.T_w_kf), 1e-9 * result.chi2_after);
}

// Dense Gauss-Newton with a numeric derivative of the whitened error of everything.
template <class Pose>
std::vector<Pose> SlowTwin(const PoseGraph<Pose>& graph, std::vector<Pose> poses) {
  using Group = PoseGroup<Pose>;
  constexpr int kN = kPoseFreedom<Pose>;
  const auto residuals = [&](const std::vector<Pose>& at) {
    Eigen::VectorXd r(kN * static_cast<int>(graph.edges.size()));
    for (size_t i = 0; i < graph.edges.size(); ++i) {
      const auto& edge = graph.edges[i];
      const PoseMatrix<Pose> U = edge.information.llt().matrixU();
      r.segment<kN>(kN * static_cast<int>(i)) = U * Group::Error(edge.T_a_b, at[edge.a], at[edge.b]).e;
    }
    return r;
  };
  const int n = static_cast<int>(poses.size());
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Eigen::VectorXd r = residuals(poses);
    Eigen::MatrixXd J(r.size(), kN * (n - 1));
    for (int k = 0; k < kN * (n - 1); ++k) {
      Tangent<Pose> step = Tangent<Pose>::Zero();
      std::vector<Pose> moved = poses;
      step[k % kN] = 1e-6;
      moved[1 + k / kN] = Group::Plus(poses[1 + k / kN], step.data());
      const Eigen::VectorXd plus = residuals(moved);
      step = -step;
      moved[1 + k / kN] = Group::Plus(poses[1 + k / kN], step.data());
      J.col(k) = (plus - residuals(moved)) / 2e-6;
    }
    const Eigen::VectorXd step = test::LeastSquares(J, -r);
    for (int i = 1; i < n; ++i) poses[i] = Group::Plus(poses[i], step.data() + kN * (i - 1));
  }
  return poses;
}

TYPED_TEST(PoseGraphTest, AgreesWithADenseNumericSolve) {
  const auto world =
      test::MakePoseGraphWorld<TypeParam>({.poses = 30, .lap = 10, .sigma_m = 0.05, .sigma_rad = 0.03});
  PoseGraphOptions options = Tight();
  options.rejection_chi2 = 1e12;
  const auto result = OptimisePoseGraph(world.graph, options);
  ASSERT_TRUE(result.ok) << result.reason;
  const auto twin = SlowTwin(world.graph, world.truth);
  EXPECT_LT(test::LargestError_m(result.T_w_kf, twin), 1e-6);
  const double chi2 = PoseGraphChi2(world.graph, twin);
  EXPECT_NEAR(result.chi2_after, chi2, 1e-9 * chi2);
}

TYPED_TEST(PoseGraphTest, ChordalPosesAreExactWithoutNoise) {
  auto world = test::MakePoseGraphWorld<TypeParam>({.poses = 60, .lap = 20});
  for (auto& edge : world.graph.edges) edge.T_a_b = world.truth[edge.a].Inverse() * world.truth[edge.b];
  std::mt19937_64 random(9);
  for (size_t i = 1; i < world.graph.poses.size(); ++i) {
    world.graph.poses[i].T_w_kf = RandomPose<TypeParam>(random, 2.0);
  }
  const auto poses = ChordalPoses(world.graph, ConstantPoses(world.graph, {}));
  ASSERT_TRUE(poses.has_value());
  EXPECT_LT(test::LargestError_m(*poses, world.truth), 1e-9);
  EXPECT_LT(PoseGraphChi2(world.graph, *poses), 1e-12);
}

TYPED_TEST(PoseGraphTest, ChordalStartReachesTheSameMinimum) {
  const test::PoseGraphSpec spec{.poses = 120, .lap = 20, .sigma_m = 0.1, .sigma_rad = 0.05, .seed = 2};
  auto world = test::MakePoseGraphWorld<TypeParam>(spec);
  PoseGraphOptions options = Tight();
  options.rejection_chi2 = 1e12;
  const auto from_odometry = OptimisePoseGraph(world.graph, options);
  ASSERT_TRUE(from_odometry.ok) << from_odometry.reason;
  std::mt19937_64 random(9);
  for (size_t i = 1; i < world.graph.poses.size(); ++i) {
    world.graph.poses[i].T_w_kf = RandomPose<TypeParam>(random, 2.0);
  }
  options.start = GraphStart::kChordal;
  const auto chordal = OptimisePoseGraph(world.graph, options);
  ASSERT_TRUE(chordal.ok) << chordal.reason;
  EXPECT_NEAR(chordal.chi2_after, from_odometry.chi2_after, 1e-9 * chordal.chi2_after);
  options.start = GraphStart::kBest;
  const auto best = OptimisePoseGraph(world.graph, options);
  EXPECT_LE(best.chi2_after, chordal.chi2_after);
}

TYPED_TEST(PoseGraphTest, EqualInputGivesEqualBits) {
  const auto world = test::MakePoseGraphWorld<TypeParam>({.poses = 100, .lap = 30});
  const auto first = OptimisePoseGraph(world.graph, PoseGraphOptions());
  const std::vector<double> elsewhere(12345, 1.0);
  const auto second = OptimisePoseGraph(world.graph, PoseGraphOptions());
  for (size_t i = 0; i < first.T_w_kf.size(); ++i) {
    EXPECT_EQ(first.T_w_kf[i].translation(), second.T_w_kf[i].translation()) << i;
    EXPECT_EQ(first.T_w_kf[i].R(), second.T_w_kf[i].R()) << i;
  }
}

TYPED_TEST(PoseGraphTest, CovariancesAgreeWithTheDenseInverse) {
  const auto world = test::MakePoseGraphWorld<TypeParam>({.poses = 40, .lap = 10});
  const auto result = OptimisePoseGraph(world.graph, Tight());
  ASSERT_TRUE(result.ok) << result.reason;
  constexpr int kN = kPoseFreedom<TypeParam>;
  const int n = static_cast<int>(world.graph.poses.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kN * n, kN * n);
  for (const auto& edge : world.graph.edges) {
    const auto error = PoseGroup<TypeParam>::Error(edge.T_a_b, result.T_w_kf[edge.a], result.T_w_kf[edge.b]);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(kN, kN * n);
    J.middleCols<kN>(kN * edge.a) = error.by_a;
    J.middleCols<kN>(kN * edge.b) = error.by_b;
    H += J.transpose() * edge.information * J;
  }
  const Eigen::MatrixXd dense = H.bottomRightCorner(kN * (n - 1), kN * (n - 1)).inverse();
  const auto covariances = PoseGraphCovariances(world.graph, result);
  EXPECT_EQ(covariances[0].norm(), 0.0);
  for (int i = 1; i < n; ++i) {
    const auto expected = dense.block<kN, kN>(kN * (i - 1), kN * (i - 1));
    EXPECT_LT((covariances[i] - expected).norm(), 1e-9 * expected.norm()) << i;
  }
}

}  // namespace
}  // namespace plslam
