// SPDX-License-Identifier: BSD-3-Clause
// The optimum of our pose graphs against that of Ceres, on public ones.
#include <gtest/gtest.h>

#include <variant>
#include <vector>

#include "tests/support/data_folder.h"
#include "tests/unit/reference/reference_graph.h"
#include "tools/pose_graph/g2o.h"
#include "tools/pose_graph/solve.h"

namespace plslam {
namespace {

/// From the result of ours, which Ceres must not be able to lower.
template <class Pose>
double LeastCost(const PoseGraph<Pose>& graph) {
  std::vector<Pose> T_w_kf;
  for (const auto& node : graph.poses) T_w_kf.push_back(node.T_w_kf);
  test::ReferenceGraph<Pose> reference(graph, T_w_kf);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &reference.problem(), &summary);
  return summary.final_cost;
}

class ReferencePoseGraph : public testing::TestWithParam<const char*> {};

TEST_P(ReferencePoseGraph, EndsInTheSameOptimum) {
  PLSLAM_REQUIRE_DATA(folder, "posegraphs");
  pose_graph::G2oFile file = pose_graph::ReadG2o((folder / (std::string(GetParam()) + ".g2o")).string());
  const pose_graph::SolveReport report = pose_graph::SolveG2o(file, {.initial = "chordal"});
  ASSERT_TRUE(report.ok) << report.reason;
  // The solved poses are those of the file's graph now.
  const double least = std::visit([](const auto& solved) { return LeastCost(solved.graph); }, file.content);
  EXPECT_NEAR(report.chi2_after, 2.0 * least, 1e-6 * report.chi2_after);
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
