#include "core/optim/bundle_solver.h"

#include <algorithm>
#include <memory>

namespace plslam {
namespace {

// Above it the reduced system is mostly zeros.
constexpr int kMaxDenselySolved = 60;
// Outliers can be told once a step gains less than this share of the cost, or what is left is less than this for a
// row; inliers alone leave 0.6.
constexpr double kNearGain = 0.5;
constexpr double kNearLoss = 1.5;

ceres::LinearSolverType ChooseSolver(const ceres::ParameterBlockOrdering& order) {
  const bool few = order.GroupSize(1) <= kMaxDenselySolved;
  if (order.GroupSize(0) == 0) return few ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  return few ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
}

}  // namespace

void BundleMonitor::PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) {
  if (new_evaluation_point) {
    for (AdjustedPose& pose : poses_) {
      if (pose.IsFree()) pose.Update();
    }
  }
  if (!evaluate_jacobians) return;
  // Jacobians at a point that was evaluated already: the step to it was accepted.
  if (new_evaluation_point) {
    loss_ = sights_.loss().loss;
  } else {
    StepTaken();
  }
}

void BundleMonitor::Start(bool trim) {
  trim_ = trim;
  finished_ = false;
  stopped_ = stop_ && *stop_;
}

void BundleMonitor::StepTaken() {
  const LossSum now = sights_.loss();
  const double gain = loss_ - now.loss;
  if (trim_ && (gain <= kNearGain * loss_ || now.loss <= kNearLoss * now.rows)) {
    trim_ = false;
    sights_.trim();
    loss_ = sights_.loss().loss;
    return;
  }
  finished_ = gain <= options_.function_tolerance * loss_;
  if (finished_) sights_.finish();
  loss_ = now.loss;
}

ceres::CallbackReturnType BundleMonitor::operator()(const ceres::IterationSummary& summary) {
  iterations_ = summary.iteration;
  stopped_ = stop_ && *stop_;
  return stopped_ || finished_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
}

ceres::Problem::Options BundleProblemOptions(BundleMonitor& monitor) {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  options.evaluation_callback = &monitor;
  return options;
}

BundlePass SolveBundle(ceres::Problem& problem, const ceres::ParameterBlockOrdering& order, BundleMonitor& monitor,
                       const BundleOptions& options) {
  // Preparing alone takes a while.
  if (monitor.stopped()) return {true, true, 0};
  ceres::Solver::Options solver;
  solver.linear_solver_type = ChooseSolver(order);
  solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>(order);
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 0.0;
  solver.parameter_tolerance = 0.0;
  // Levenberg-Marquardt scales by the diagonal itself.
  solver.jacobi_scaling = false;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.callbacks.push_back(&monitor);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  return {summary.IsSolutionUsable(), monitor.stopped(), monitor.iterations()};
}

}  // namespace plslam
