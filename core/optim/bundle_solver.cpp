#include "core/optim/bundle_solver.h"

#include <algorithm>
#include <memory>

namespace plslam {
namespace {

// Above it the reduced system is mostly zeros.
constexpr int kMaxDensePoses = 60;
constexpr double kInitialRadius = 1e8;

// Ends the pass when asked to, or when a step has gained little. Ceres' own test throws such a step away.
class Monitor : public ceres::IterationCallback {
 public:
  Monitor(double function_tolerance, const std::atomic<bool>* stop) : tolerance_(function_tolerance), stop_(stop) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    stopped_ = stop_ && *stop_;
    const bool gained_little = summary.iteration > 0 && summary.step_is_successful &&
                               summary.cost_change <= tolerance_ * (summary.cost + summary.cost_change);
    return stopped_ || gained_little ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

  bool stopped() const { return stopped_; }

 private:
  double tolerance_;
  const std::atomic<bool>* stop_;
  bool stopped_ = false;
};

ceres::LinearSolverType ChooseSolver(const ceres::ParameterBlockOrdering& order) {
  const bool few = order.GroupSize(1) <= kMaxDensePoses;
  if (order.GroupSize(0) == 0) return few ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  return few ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
}

}  // namespace

void ViewUpdater::PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_evaluation_point) {
  if (!new_evaluation_point) return;
  for (AdjustedPose& pose : poses_) {
    if (pose.IsFree()) pose.Update();
  }
}

ceres::Problem::Options BundleProblemOptions(ViewUpdater& views) {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  options.evaluation_callback = &views;
  return options;
}

BundlePass SolveBundle(ceres::Problem& problem, const ceres::ParameterBlockOrdering& order,
                       const BundleOptions& options, const std::atomic<bool>* stop) {
  Monitor monitor(options.function_tolerance, stop);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ChooseSolver(order);
  solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>(order);
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 0.0;
  solver.parameter_tolerance = 0.0;
  // Levenberg-Marquardt scales by the diagonal itself.
  solver.jacobi_scaling = false;
  // The start is near: what damps a depth by the information across the view would take many steps.
  solver.initial_trust_region_radius = kInitialRadius;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.callbacks.push_back(&monitor);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  BundlePass pass;
  pass.ok = summary.IsSolutionUsable();
  pass.stopped = monitor.stopped();
  pass.iterations = std::max(0, static_cast<int>(summary.iterations.size()) - 1);
  return pass;
}

}  // namespace plslam
