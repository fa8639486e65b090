// SPDX-License-Identifier: BSD-3-Clause
// The optimum of our pose graphs against that of Ceres, on public ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <variant>
#include <vector>

#include "core/optim/pose_graph/pose_graph_group.h"
#include "tests/support/data_folder.h"
#include "tests/unit/reference/reference_graph.h"
#include "tools/pose_graph/g2o.h"
#include "tools/pose_graph/solve.h"

namespace plslam {
namespace {

struct Optimum {
  double cost = 0.0;
  /// Largest difference of a position from ours, as a share of the graph's extent, and of a rotation [rad].
  double difference = 0.0;
  double difference_rad = 0.0;
};

double Turn_rad(const SE3& a, const SE3& b) { return (a.Inverse() * b).Log().tail<3>().norm(); }
double Turn_rad(const SE2& a, const SE2& b) {
  return std::abs(std::remainder(a.angle() - b.angle(), 2.0 * std::numbers::pi));
}

/// From poses that are displaced from our result, all but the first.
template <class Pose>
Optimum OptimumOf(const PoseGraph<Pose>& graph) {
  std::mt19937 random(1);
  std::normal_distribution<double> gauss(0.0, 0.02);
  std::vector<Pose> T_w_kf;
  for (const auto& node : graph.poses) {
    std::array<double, kPoseFreedom<Pose>> step{};
    for (double& value : step) value = T_w_kf.empty() ? 0.0 : gauss(random);
    T_w_kf.push_back(PoseGroup<Pose>::Plus(node.T_w_kf, step.data()));
  }
  test::ReferenceGraph<Pose> reference(graph, T_w_kf);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-16;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-16;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &reference.problem(), &summary);
  double extent_m = 0.0;
  for (const auto& node : graph.poses) extent_m = std::max(extent_m, node.T_w_kf.translation().norm());
  Optimum optimum{summary.final_cost, 0.0, 0.0};
  for (size_t i = 0; i < graph.poses.size(); ++i) {
    const Pose& ours = graph.poses[i].T_w_kf;
    const Pose pose = reference.T_w_kf(i);
    const double difference_m = (ours.translation() - pose.translation()).norm();
    optimum.difference = std::max(optimum.difference, difference_m / extent_m);
    optimum.difference_rad = std::max(optimum.difference_rad, Turn_rad(ours, pose));
  }
  return optimum;
}

class ReferencePoseGraph : public testing::TestWithParam<const char*> {};

TEST_P(ReferencePoseGraph, EndsInTheSameOptimum) {
  PLSLAM_REQUIRE_DATA(folder, "posegraphs");
  pose_graph::G2oFile file = pose_graph::ReadG2o((folder / (std::string(GetParam()) + ".g2o")).string());
  pose_graph::SolveOptions options{.initial = pose_graph::InitialPoses::kChordal};
  options.graph.function_tolerance = 1e-16;
  const pose_graph::SolveReport report = pose_graph::SolveG2o(file, options);
  ASSERT_TRUE(report.ok) << report.reason;
  // The solved poses are those of the file's graph now.
  const Optimum optimum = std::visit([](const auto& solved) { return OptimumOf(solved.graph); }, file.content);
  EXPECT_NEAR(report.chi2_after, 2.0 * optimum.cost, 1e-6 * report.chi2_after);
  EXPECT_LT(optimum.difference, 1e-6);
  EXPECT_LT(optimum.difference_rad, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Public, ReferencePoseGraph,
                         testing::Values("tinyGrid3D", "smallGrid3D", "parking-garage", "MIT", "intel"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace plslam
