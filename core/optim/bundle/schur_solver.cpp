// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/schur_solver.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

constexpr double kFlat = 1e-10;

}  // namespace

SchurSolver::SchurSolver(std::vector<AdjustedPose>& poses, const RelativePoses& relative,
                         const InertialChain& inertial, const std::array<EliminatedLandmarks*, 2>& kinds,
                         const BundleOptions& options)
    : poses_(poses),
      relative_(relative),
      inertial_(inertial),
      kinds_(kinds),
      options_(options),
      before_(poses.size()),
      system_(CountFree(poses), CountFree(poses) <= options.max_dense_poses ? PoseSystem::Storage::kDense
                                                                            : PoseSystem::Storage::kSparse),
      reduced_(system_) {}

BundlePass SchurSolver::Run(StepControl& control, bool trim) {
  BundlePass pass{true, control.IsStopped(), 0};
  if (pass.stopped) return pass;
  TrustRegion region;
  double loss = Linearise();
  control.Start(trim);
  int without_step = 0;
  while (pass.iterations < options_.max_iterations && !IsFlat() && !pass.stopped) {
    ++pass.iterations;
    const std::optional<double> predicted_reduction = Step(region.damping());
    pass.stopped = control.IsStopped();
    if (!predicted_reduction || *predicted_reduction <= 0.0) {
      if (++without_step == TrustRegion::kMaxWithoutStep) {
        pass.ok = predicted_reduction.has_value();
        break;
      }
      region.Rejected();
      continue;
    }
    without_step = 0;
    const double gain = loss - Loss();
    if (gain > TrustRegion::kMinGainRatio * *predicted_reduction) {
      region.Accepted(gain / *predicted_reduction);
      if (!control.ShouldContinue()) break;
      if (pass.iterations < options_.max_iterations && !pass.stopped) loss = Linearise();
    } else {
      RollBack();
      region.Rejected();
      if (gain == 0.0) break;
    }
  }
  return pass;
}

double SchurSolver::Linearise() {
  system_.SetZero();
  double loss = relative_.Linearise(system_) + inertial_.Linearise(system_);
  for (EliminatedLandmarks* kind : kinds_) loss += kind->Linearise(system_);
  return loss;
}

double SchurSolver::Loss() const {
  double loss = relative_.Loss() + inertial_.Loss();
  for (const EliminatedLandmarks* kind : kinds_) loss += kind->Loss();
  return loss;
}

bool SchurSolver::IsFlat() const {
  double steepest = system_.g().size() == 0 ? 0.0 : system_.g().cwiseAbs().maxCoeff();
  for (const EliminatedLandmarks* kind : kinds_) steepest = std::max(steepest, kind->LargestGradient());
  return steepest <= kFlat;
}

std::optional<double> SchurSolver::Step(const Damping& damping) {
  reduced_.Assign(system_);
  const Eigen::VectorXd of_poses = damping.Of(system_.DiagonalValues());
  reduced_.AddToDiagonal(of_poses);
  for (EliminatedLandmarks* kind : kinds_) {
    if (!kind->Eliminate(damping, reduced_)) return std::nullopt;
  }
  const std::optional<Eigen::VectorXd> solution = reduced_.Solve();
  if (!solution) return std::nullopt;
  const Eigen::VectorXd& step = *solution;
  double predicted_reduction = step.dot(of_poses.cwiseProduct(step) - system_.g());
  for (EliminatedLandmarks* kind : kinds_) predicted_reduction += kind->Step(step);
  for (size_t i = 0; i < poses_.size(); ++i) {
    if (!poses_[i].IsFree()) continue;
    before_[i] = poses_[i].x;
    poses_[i].x += step.segment<6>(6 * poses_[i].column);
    poses_[i].Update();
  }
  if (predicted_reduction > 0.0) return predicted_reduction;
  RollBack();
  return std::isfinite(predicted_reduction) ? std::optional(predicted_reduction) : std::nullopt;
}

void SchurSolver::RollBack() {
  for (size_t i = 0; i < poses_.size(); ++i) {
    if (!poses_[i].IsFree()) continue;
    poses_[i].x = before_[i];
    poses_[i].Update();
  }
  for (EliminatedLandmarks* kind : kinds_) kind->RollBack();
}

}  // namespace plslam
