// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_solver.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "core/optim/pose_graph/pose_graph_check.h"
#include "core/optim/pose_graph/pose_graph_cost.h"

namespace plslam {
namespace {

ceres::Problem::Options Ownership() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

ceres::Solver::Options SolverOptions(const PoseGraphOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = 0.0;
  solver.parameter_tolerance = 1e-12;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace

template <class Pose>
PoseGraphSolve<Pose> SolvePoseGraph(const PoseGraph<Pose>& graph, const std::vector<bool>& rejected,
                                    const std::vector<Pose>& start, const PoseGraphOptions& options) {
  using Group = PoseGroup<Pose>;
  // One array, because Ceres orders parameters by their addresses.
  std::vector<double> parameters(start.size() * Group::kParameters);
  const auto block = [&](size_t pose) { return parameters.data() + pose * Group::kParameters; };
  for (size_t i = 0; i < start.size(); ++i) Group::Store(start[i], block(i));

  PoseManifold<Pose> manifold;
  std::deque<PoseGraphCost<Pose>> costs;
  ceres::Problem problem(Ownership());
  const std::vector<bool> constant = ConstantPoses(graph, rejected);
  for (size_t i = 0; i < start.size(); ++i) {
    problem.AddParameterBlock(block(i), Group::kParameters, &manifold);
    if (constant[i]) problem.SetParameterBlockConstant(block(i));
  }
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    if (rejected[i]) continue;
    costs.emplace_back(graph.edges[i]);
    problem.AddResidualBlock(&costs.back(), nullptr, block(graph.edges[i].a), block(graph.edges[i].b));
  }
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options), &problem, &summary);

  PoseGraphSolve<Pose> solve;
  // The first entry is the start.
  solve.iterations = std::max(0, static_cast<int>(summary.iterations.size()) - 1);
  solve.chi2 = 2.0 * summary.final_cost;
  const bool finite = std::all_of(parameters.begin(), parameters.end(), [](double x) { return std::isfinite(x); });
  solve.ok = summary.IsSolutionUsable() && finite && std::isfinite(solve.chi2);
  if (!solve.ok) return solve;
  for (size_t i = 0; i < start.size(); ++i) solve.T_w_kf.push_back(constant[i] ? start[i] : Group::Load(block(i)));
  return solve;
}

template PoseGraphSolve<SE3> SolvePoseGraph(const PoseGraph<SE3>&, const std::vector<bool>&, const std::vector<SE3>&,
                                            const PoseGraphOptions&);
template PoseGraphSolve<SE2> SolvePoseGraph(const PoseGraph<SE2>&, const std::vector<bool>&, const std::vector<SE2>&,
                                            const PoseGraphOptions&);

}  // namespace plslam
