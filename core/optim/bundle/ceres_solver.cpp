// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/ceres_solver.h"

#include <memory>

namespace plslam {
namespace {

// Parameters are those of the free poses, a before b.
class CeresRelativePose final : public ceres::CostFunction {
 public:
  explicit CeresRelativePose(const RelativePoseCost& cost) : cost_(cost) {
    set_num_residuals(6);
    for (const AdjustedPose* pose : {&cost.a(), &cost.b()}) {
      if (pose->IsFree()) mutable_parameter_block_sizes()->push_back(6);
    }
  }

  bool Evaluate(double const* const* /*parameters*/, double* residuals, double** jacobians) const override {
    const bool free_a = cost_.a().IsFree();
    double* by_a = jacobians && free_a ? jacobians[0] : nullptr;
    double* by_b = jacobians && cost_.b().IsFree() ? jacobians[free_a ? 1 : 0] : nullptr;
    cost_.Evaluate(residuals, by_a, by_b);
    return true;
  }

 private:
  const RelativePoseCost& cost_;
};

ceres::Problem::Options ProblemOptions(ceres::EvaluationCallback* callback) {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  options.evaluation_callback = callback;
  return options;
}

}  // namespace

CeresSolver::CeresSolver(std::vector<AdjustedPose>& poses, const RelativePoses& relative, size_t landmark_numbers,
                         const BundleOptions& options)
    : poses_(poses),
      options_(options),
      observation_loss_(options.huber_delta),
      relative_loss_(RelativePoses::kDelta),
      problem_(ProblemOptions(this)),
      parameters_(landmark_numbers) {
  for (AdjustedPose& pose : poses_) {
    if (!pose.IsAdjusted()) continue;
    problem_.AddParameterBlock(pose.x.data(), 6);
    order_.AddElementToGroup(pose.x.data(), 1);
  }
  for (const RelativePoseCost& cost : relative.costs()) {
    std::vector<double*> blocks;
    for (AdjustedPose* pose : {&cost.a(), &cost.b()}) {
      if (pose->IsFree()) blocks.push_back(pose->x.data());
    }
    problem_.AddResidualBlock(new CeresRelativePose(cost), &relative_loss_, blocks);
  }
}

BundlePass CeresSolver::Run(StepControl& control, bool trim) {
  pass_ = {true, control.IsStopped(), 0};
  // Preparing alone takes a while.
  if (pass_.stopped) return pass_;
  control_ = &control;
  trim_ = trim;
  finished_ = false;
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(), &problem_, &summary);
  Follow();
  pass_.ok = summary.IsSolutionUsable();
  return pass_;
}

ceres::Solver::Options CeresSolver::SolverOptions() {
  ceres::Solver::Options solver;
  solver.linear_solver_type = order_.GroupSize(0) == 0 ? ceres::SPARSE_NORMAL_CHOLESKY : ceres::SPARSE_SCHUR;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>(order_);
  solver.max_num_iterations = options_.max_iterations;
  solver.function_tolerance = 0.0;
  solver.parameter_tolerance = 0.0;
  // Levenberg-Marquardt scales by the diagonal itself.
  solver.jacobi_scaling = false;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.callbacks.push_back(this);
  return solver;
}

void CeresSolver::Follow() {
  for (AdjustedPose& pose : poses_) {
    if (pose.IsFree()) pose.Update();
  }
  for (const auto& follow : follow_) follow();
}

void CeresSolver::PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) {
  if (new_evaluation_point) Follow();
  if (!evaluate_jacobians) return;
  // Jacobians at a point that was evaluated already: the step to it was accepted.
  if (new_evaluation_point) {
    control_->Start(trim_);
  } else {
    finished_ = !control_->GoesOn();
  }
}

ceres::CallbackReturnType CeresSolver::operator()(const ceres::IterationSummary& summary) {
  pass_.iterations = summary.iteration;
  pass_.stopped = control_->IsStopped();
  return pass_.stopped || finished_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
}

}  // namespace plslam
