// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/solve.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>

#include "core/optim/pose_graph/pose_graph_check.h"
#include "core/optim/pose_graph/pose_graph_chordal.h"
#include "core/optim/pose_graph/pose_graph_group.h"
#include "tools/pose_graph/pose_graph_chain.h"

namespace plslam::pose_graph {
namespace {

template <class Pose>
void Perturb(PoseGraph<Pose>& graph, double sigma, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, sigma);
  const std::vector<bool> constant = ConstantPoses(graph, {});
  for (size_t i = 0; i < graph.poses.size(); ++i) {
    if (constant[i]) continue;
    Eigen::Matrix<double, kPoseFreedom<Pose>, 1> step;
    for (int k = 0; k < step.size(); ++k) step[k] = noise(random);
    graph.poses[i].T_w_kf = PoseGroup<Pose>::Plus(graph.poses[i].T_w_kf, step.data());
  }
}

/// Empty where the relaxation cannot be solved.
template <class Pose>
std::vector<Pose> PosesFrom(InitialPoses initial, const G2oGraph<Pose>& file) {
  if (initial == InitialPoses::kOdometry) return ChainedPoses(file.graph);
  if (initial == InitialPoses::kFile) return ChainedPoses(file.graph, file.given);
  return ChordalPoses(file.graph, ConstantPoses(file.graph, {})).value_or(std::vector<Pose>());
}

template <class Pose>
bool SetStart(G2oGraph<Pose>& file, const SolveOptions& options) {
  const std::vector<Pose> poses = PosesFrom(options.initial, file);
  if (poses.size() != file.graph.poses.size()) return false;
  for (size_t i = 0; i < poses.size(); ++i) file.graph.poses[i].T_w_kf = poses[i];
  file.given.assign(poses.size(), true);
  if (options.perturb > 0.0) Perturb(file.graph, options.perturb, options.seed);
  return true;
}

template <class Pose>
SolveReport Solve(G2oGraph<Pose>& file, const SolveOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const std::string objection = PoseGraphObjection(file.graph);
  if (!objection.empty()) return {.reason = objection};
  if (!SetStart(file, options)) return {.reason = "the chordal relaxation cannot be solved"};
  for (PoseGraphMotion<Pose>& edge : file.graph.edges) {
    edge.robust = options.reject && std::abs(edge.a - edge.b) != 1;
  }
  PoseGraphOptions graph = options.graph;
  if (options.initial == InitialPoses::kChordal) graph.start = GraphStart::kGiven;
  PoseGraphSolution<Pose> solution = OptimisePoseGraph(file.graph, graph);
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
  for (size_t i = 0; i < file.graph.poses.size(); ++i) file.graph.poses[i].T_w_kf = solution.T_w_kf[i];
  return {.ok = solution.ok,
          .reason = solution.reason,
          .poses = static_cast<int>(file.graph.poses.size()),
          .edges = static_cast<int>(file.graph.edges.size()),
          .rejected = static_cast<int>(std::count(solution.rejected.begin(), solution.rejected.end(), true)),
          .iterations = solution.iterations,
          .chi2_before = solution.chi2_before,
          .chi2_after = solution.chi2_after,
          .seconds = time.count()};
}

}  // namespace

SolveReport SolveG2o(G2oFile& file, const SolveOptions& options) {
  return std::visit([&](auto& graph) { return Solve(graph, options); }, file.content);
}

}  // namespace plslam::pose_graph
