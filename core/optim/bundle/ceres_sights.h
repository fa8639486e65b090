#pragma once

#include <algorithm>
#include <cmath>

#include <ceres/cost_function.h>

#include "core/optim/bundle/adjusted_sight.h"

namespace plslam {

/// One sight as Ceres sees it. The solver keeps its pose and landmark at the parameters under evaluation. Sights that do
/// not take part cost nothing, and neither does any once `finished`.
template <class Cost>
class CeresSight final : public ceres::CostFunction {
 public:
  CeresSight(const AdjustedSight<Cost>& sight, const bool& finished) : sight_(sight), finished_(finished) {
    set_num_residuals(sight.cost.rows());
    if (sight.landmark->free) mutable_parameter_block_sizes()->push_back(Cost::Landmark::kSize);
    if (sight.pose->IsFree()) mutable_parameter_block_sizes()->push_back(6);
  }

  bool Evaluate(double const* const* /*parameters*/, double* residuals, double** jacobians) const override {
    const bool free_landmark = sight_.landmark->free;
    double* by_landmark = jacobians && free_landmark ? jacobians[0] : nullptr;
    double* by_pose = jacobians && sight_.pose->IsFree() ? jacobians[free_landmark ? 1 : 0] : nullptr;
    const bool takes_part = sight_.active && !finished_;
    if (takes_part && sight_.Evaluate(residuals, by_pose, by_landmark)) return true;
    const int rows = sight_.cost.rows();
    std::fill_n(residuals, rows, 0.0);
    if (takes_part) residuals[0] = std::sqrt(sight_.SquaredBehind());
    if (by_landmark) std::fill_n(by_landmark, rows * Cost::Landmark::kSize, 0.0);
    if (by_pose) std::fill_n(by_pose, rows * 6, 0.0);
    return true;
  }

 private:
  const AdjustedSight<Cost>& sight_;
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

}  // namespace plslam
