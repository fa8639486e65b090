// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

#include "core/geometry/symmetric.h"
#include "core/optim/pose_graph/pose_graph_check.h"
#include "core/optim/pose_graph/pose_graph_chordal.h"
#include "core/optim/pose_graph/pose_graph_group.h"
#include "core/optim/pose_graph/pose_graph_marginals.h"
#include "core/optim/pose_graph/pose_graph_rejection.h"
#include "core/optim/pose_graph/pose_graph_solver.h"

namespace plslam {
namespace {

template <class Pose>
std::vector<Pose> GivenPoses(const PoseGraph<Pose>& graph) {
  std::vector<Pose> poses;
  for (const PoseGraphNode<Pose>& node : graph.poses) poses.push_back(node.T_w_kf);
  return poses;
}

template <class Pose>
double Chi2(const PoseGraph<Pose>& graph, const std::vector<Pose>& T_w_kf) {
  double sum = 0.0;
  for (const PoseGraphMotion<Pose>& edge : graph.edges) sum += EdgeChi2(edge, T_w_kf);
  return sum;
}

/// The optimisation of one graph, with its rejected edges.
template <class Pose>
class Optimiser {
 public:
  Optimiser(const PoseGraph<Pose>& graph, const PoseGraphOptions& options)
      : graph_(graph), options_(options), given_(GivenPoses(graph)), rejected_(graph.edges.size(), false) {}

  PoseGraphSolution<Pose> Run() {
    PoseGraphSolution<Pose> solution;
    solution.T_w_kf = given_;
    solution.rejected = rejected_;
    solution.reason = PoseGraphObjection(graph_);
    if (!solution.reason.empty()) return solution;
    solution.chi2_before = Chi2(graph_, given_);
    if (!std::isfinite(solution.chi2_before)) {
      solution.chi2_before = 0.0;
      solution.reason = "the chi-square of the given poses is too large to represent";
      return solution;
    }
    PoseGraphSolve<Pose> best = SolveFromStart(rejected_);
    if (!best.ok) {
      solution.reason = "the solver found no step";
      return solution;
    }
    while (RejectOne(best)) {
    }
    solution.ok = true;
    solution.T_w_kf = std::move(best.T_w_kf);
    solution.chi2_after = best.chi2;
    solution.rejected = rejected_;
    solution.iterations = iterations_;
    return solution;
  }

 private:
  PoseGraphSolve<Pose> Solve(const std::vector<bool>& rejected, const std::vector<Pose>& start) {
    PoseGraphSolve<Pose> solve = SolvePoseGraph(graph_, rejected, start, options_);
    iterations_ += solve.iterations;
    return solve;
  }

  PoseGraphSolve<Pose> SolveFromStart(const std::vector<bool>& rejected) {
    PoseGraphSolve<Pose> solve;
    if (options_.start != GraphStart::kGiven) {
      const auto chordal = ChordalPoses(graph_, ConstantPoses(graph_, rejected));
      if (chordal) solve = Solve(rejected, *chordal);
    }
    if (solve.ok && options_.start == GraphStart::kChordal) return solve;
    const PoseGraphSolve<Pose> from_given = Solve(rejected, given_);
    const bool lower = from_given.ok && (!solve.ok || from_given.chi2 < solve.chi2);
    return lower ? from_given : solve;
  }

  /// Rejects the robust edge that the others contradict most; returns false if there is no candidate. An edge that was
  /// confirmed by a solve without it is not tried again.
  bool RejectOne(PoseGraphSolve<Pose>& best) {
    cleared_.resize(graph_.edges.size(), false);
    const bool any = std::any_of(graph_.edges.begin(), graph_.edges.end(), [](const auto& e) { return e.robust; });
    if (!any || best.chi2 <= options_.rejection_chi2) return false;
    std::vector<double> gains = DeletionGains(graph_, best.T_w_kf, rejected_);
    for (size_t i = 0; i < gains.size(); ++i) {
      if (cleared_[i]) gains[i] = 0.0;
    }
    const auto worst = std::max_element(gains.begin(), gains.end());
    if (worst == gains.end() || *worst <= options_.rejection_chi2) return false;
    const auto edge = static_cast<size_t>(worst - gains.begin());
    std::vector<bool> without = rejected_;
    without[edge] = true;
    PoseGraphSolve<Pose> solve = SolveFromStart(without);
    if (solve.ok && solve.chi2 + options_.rejection_chi2 < best.chi2) {
      rejected_ = std::move(without);
      best = std::move(solve);
    } else {
      cleared_[edge] = true;
    }
    return true;
  }

  const PoseGraph<Pose>& graph_;
  const PoseGraphOptions& options_;
  const std::vector<Pose> given_;
  std::vector<bool> rejected_;
  std::vector<bool> cleared_;
  int iterations_ = 0;
};

template <class Pose>
std::vector<PoseMatrix<Pose>> Covariances(const PoseGraph<Pose>& graph, const PoseGraphSolution<Pose>& solution) {
  std::vector<PoseMatrix<Pose>> covariances(graph.poses.size(), PoseMatrix<Pose>::Zero());
  if (!solution.ok) return covariances;
  const PoseGraphMarginals<Pose> marginals(graph, solution.T_w_kf, solution.rejected);
  if (!marginals.ok()) return covariances;
  for (size_t i = 0; i < covariances.size(); ++i) covariances[i] = marginals.OfPose(static_cast<int>(i));
  return covariances;
}

}  // namespace

PoseGraphSolution<SE3> OptimisePoseGraph(const PoseGraph<SE3>& graph, const PoseGraphOptions& options) {
  return Optimiser<SE3>(graph, options).Run();
}

PoseGraphSolution<SE2> OptimisePoseGraph(const PoseGraph<SE2>& graph, const PoseGraphOptions& options) {
  return Optimiser<SE2>(graph, options).Run();
}

std::vector<PoseMatrix<SE3>> PoseGraphCovariances(const PoseGraph<SE3>& graph,
                                                  const PoseGraphSolution<SE3>& solution) {
  return Covariances(graph, solution);
}

std::vector<PoseMatrix<SE2>> PoseGraphCovariances(const PoseGraph<SE2>& graph,
                                                  const PoseGraphSolution<SE2>& solution) {
  return Covariances(graph, solution);
}

double PoseGraphChi2(const PoseGraph<SE3>& graph, const std::vector<SE3>& T_w_kf) { return Chi2(graph, T_w_kf); }
double PoseGraphChi2(const PoseGraph<SE2>& graph, const std::vector<SE2>& T_w_kf) { return Chi2(graph, T_w_kf); }

std::optional<Matrix6d> InformationFromCovariance(const Matrix6d& covariance) {
  if (!covariance.allFinite()) return std::nullopt;
  const Matrix6d symmetric = 0.5 * (covariance + covariance.transpose());
  if (!IsPositiveDefinite<6>(symmetric)) return std::nullopt;
  const Matrix6d inverse = InverseOfPositiveDefinite<6>(symmetric);
  const Matrix6d information = 0.5 * (inverse + inverse.transpose());
  if (!information.allFinite() || !IsPositiveDefinite<6>(information)) return std::nullopt;
  return information;
}

}  // namespace plslam
