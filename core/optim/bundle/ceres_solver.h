// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/ceres.h>
#include <ceres/cost_function.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/optim/bundle/adjusted_observation.h"
#include "core/optim/bundle/camera_view.h"
#include "core/optim/bundle/observation_group.h"
#include "core/optim/bundle/relative_poses.h"
#include "core/optim/bundle/step_control.h"

namespace plslam {

/// One observation as Ceres sees it. The solver keeps its pose and landmark at the parameters under evaluation.
/// Observations that do not take part cost nothing, and neither does any once `finished`.
template <class Cost>
class CeresObservation final : public ceres::CostFunction {
 public:
  CeresObservation(const AdjustedObservation<Cost>& observation, const bool& finished)
      : observation_(observation), finished_(finished) {
    set_num_residuals(observation.cost.rows());
    if (observation.landmark->free) mutable_parameter_block_sizes()->push_back(Cost::Landmark::kSize);
    if (observation.pose->IsFree()) mutable_parameter_block_sizes()->push_back(6);
  }

  bool Evaluate(double const* const* /*parameters*/, double* residuals, double** jacobians) const override {
    const bool free_landmark = observation_.landmark->free;
    double* by_landmark = jacobians && free_landmark ? jacobians[0] : nullptr;
    double* by_pose = jacobians && observation_.pose->IsFree() ? jacobians[free_landmark ? 1 : 0] : nullptr;
    const bool takes_part = observation_.active && !finished_;
    if (takes_part && observation_.Evaluate(residuals, by_pose, by_landmark)) return true;
    const int rows = observation_.cost.rows();
    std::fill_n(residuals, rows, 0.0);
    if (takes_part) residuals[0] = std::sqrt(observation_.SquaredBehind());
    if (by_landmark) std::fill_n(by_landmark, rows * Cost::Landmark::kSize, 0.0);
    if (by_pose) std::fill_n(by_pose, rows * 6, 0.0);
    return true;
  }

 private:
  const AdjustedObservation<Cost>& observation_;
  const bool& finished_;
};

/// The weak prior of a landmark.
template <class Landmark>
class CeresPrior final : public ceres::CostFunction {
 public:
  using Weight = Eigen::Matrix<double, Landmark::kSize, Landmark::kSize>;

  CeresPrior(const Landmark& landmark, const Weight& weight, const bool& finished)
      : landmark_(landmark), weight_(weight), finished_(finished) {
    set_num_residuals(Landmark::kSize);
    mutable_parameter_block_sizes()->push_back(Landmark::kSize);
  }

  bool Evaluate(double const* const* /*parameters*/, double* residuals, double** jacobians) const override {
    const double on = finished_ ? 0.0 : 1.0;
    Eigen::Map<typename Landmark::Parameters>{residuals} = on * weight_ * (landmark_.x - landmark_.start);
    // Symmetric, so rows or columns first are the same.
    if (jacobians && jacobians[0]) Eigen::Map<Weight>{jacobians[0]} = on * weight_;
    return true;
  }

 private:
  const Landmark& landmark_;
  Weight weight_;
  const bool& finished_;
};

/// Levenberg-Marquardt by Ceres: for many poses, whose reduced system is mostly zeros (sparse Schur complement,
/// SuiteSparse).
///
/// It keeps poses and landmarks at the parameters under evaluation, and ends a pass when a step has gained little:
/// Ceres' own test throws that step away, or evaluates Jacobians that nobody uses.
class CeresSolver : private ceres::EvaluationCallback, private ceres::IterationCallback {
 public:
  /// All must outlive it. `landmark_numbers`: parameters of all landmarks that will be added.
  CeresSolver(std::vector<AdjustedPose>& poses, const RelativePoses& relative, size_t landmark_numbers,
              const BundleOptions& options);

  /// Landmarks of one feature type: eliminated first (group 0).
  template <class Cost>
  void Add(ObservationGroup<Cost>& group);

  /// As `SchurSolver::Run`.
  BundlePass Run(StepControl& control, bool trim);

 private:
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override;

  ceres::Solver::Options SolverOptions();
  void Follow();

  std::vector<AdjustedPose>& poses_;
  const BundleOptions& options_;
  ceres::SoftLOneLoss observation_loss_;
  ceres::SoftLOneLoss relative_loss_;
  ceres::Problem problem_;
  ceres::ParameterBlockOrdering order_;
  /// Ceres orders parameters by their addresses, so those of all landmarks are in one piece for equal input to give
  /// equal output.
  std::vector<double> parameters_;
  size_t parameters_used_ = 0;
  std::vector<std::function<void()>> follow_;
  StepControl* control_ = nullptr;
  BundlePass pass_;
  bool trim_ = false;
  bool finished_ = false;
};

template <class Cost>
void CeresSolver::Add(ObservationGroup<Cost>& group) {
  constexpr int kSize = ObservationGroup<Cost>::kSize;
  double* const first = parameters_.data() + parameters_used_;
  parameters_used_ += kSize * group.landmarks().size();
  follow_.push_back([first, &group] {
    const double* from = first;
    for (auto& landmark : group.landmarks()) {
      std::copy_n(from, kSize, landmark.x.data());
      from += kSize;
    }
  });
  group.ForEachLandmark([&](size_t i, const AdjustedObservation<Cost>* begin, const AdjustedObservation<Cost>* end) {
    const auto& landmark = group.landmarks()[i];
    double* const x = first + kSize * i;
    std::copy_n(landmark.x.data(), kSize, x);
    const bool adjusted = landmark.free && begin != end;
    for (const AdjustedObservation<Cost>* observation = begin; observation != end; ++observation) {
      std::vector<double*> blocks;
      if (adjusted) blocks.push_back(x);
      if (observation->pose->IsFree()) blocks.push_back(observation->pose->x.data());
      if (!blocks.empty())
        problem_.AddResidualBlock(new CeresObservation<Cost>(*observation, finished_), &observation_loss_, blocks);
    }
    if (!adjusted) return;
    order_.AddElementToGroup(x, 0);
    if (!group.HasPrior(i)) return;
    using Landmark = typename Cost::Landmark;
    problem_.AddResidualBlock(new CeresPrior<Landmark>(landmark, group.PriorWeight(i), finished_), nullptr, x);
  });
}

}  // namespace plslam
