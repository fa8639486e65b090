#pragma once

#include <algorithm>
#include <cmath>

#include <ceres/cost_function.h>
#include <Eigen/Cholesky>

#include "core/motion/robust.h"
#include "core/optim/sight_cost.h"

namespace plslam {

/// All sights of one free landmark by fixed poses as one residual of Ceres. They depend on nothing but the landmark, so their
/// weighted sum H, g and loss say all: the Jacobian is the root of H, residuals are such that gradient and cost
/// are exact. In a local map half of the sights are of this kind, and Ceres' share of the time falls by as much.
template <class Cost>
class FixedViewsCost final : public ceres::CostFunction {
 public:
  static constexpr int kSize = Cost::Landmark::kSize;

  /// Of the sights in the range that are of fixed poses.
  FixedViewsCost(const SightCostFunction<Cost>* begin, const SightCostFunction<Cost>* end,
                 const SightContext& context)
      : begin_(begin), end_(end), context_(context) {
    set_num_residuals(kSize + 1);
    mutable_parameter_block_sizes()->push_back(kSize);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const bool derivatives = jacobians && jacobians[0];
    std::fill_n(residuals, kSize + 1, 0.0);
    if (derivatives) std::fill_n(jacobians[0], (kSize + 1) * kSize, 0.0);
    Sums sums;
    for (const SightCostFunction<Cost>* sight = begin_; sight != end_; ++sight) {
      if (!sight->pose->IsFree()) Add(*sight, parameters[0], derivatives, sums);
    }
    if (derivatives && sums.loss > 0.0) Factor(sums, residuals, jacobians[0]);
    double explained = 0.0;
    for (int i = 0; i < kSize; ++i) explained += residuals[i] * residuals[i];
    residuals[kSize] = std::sqrt(std::max(0.0, sums.loss - explained));
    return true;
  }

 private:
  using Information = Eigen::Matrix<double, kSize, kSize>;
  using Vector = Eigen::Matrix<double, kSize, 1>;

  struct Sums {
    Information H = Information::Zero();
    Vector g = Vector::Zero();
    double loss = 0.0;
  };

  void Add(const SightCostFunction<Cost>& sight, const double* x, bool derivatives, Sums& sums) const {
    double r[Cost::kMaxRows];
    double J[Cost::kMaxRows * kSize];
    const double* parameters[] = {x};
    double* jacobians[] = {J};
    sight.Evaluate(parameters, r, derivatives ? jacobians : nullptr);
    const double squared = Eigen::Map<const Eigen::VectorXd>(r, sight.cost.rows()).squaredNorm();
    sums.loss += PseudoHuberLoss(squared, context_.huber_delta);
    if (!derivatives) return;
    const double weight = PseudoHuberWeight(squared, context_.huber_delta);
    for (int row = 0; row < sight.cost.rows(); ++row) {
      const Eigen::Map<const Vector> j(J + row * kSize);
      sums.H.noalias() += weight * j * j.transpose();
      sums.g += weight * r[row] * j;
    }
  }

  // r = L^-1 g and J = L^T, so that J^T J = H and J^T r = g.
  static void Factor(Sums& sums, double* residuals, double* jacobian) {
    // Sights may leave directions open.
    sums.H.diagonal().array() += 1e-12 * sums.H.trace() + 1e-12;
    const Eigen::LLT<Information> llt(sums.H);
    Eigen::Map<Vector>{residuals} = llt.matrixL().solve(sums.g);
    for (int i = 0; i < kSize; ++i) {
      for (int k = i; k < kSize; ++k) jacobian[i * kSize + k] = llt.matrixLLT()(k, i);
    }
  }

  const SightCostFunction<Cost>* begin_;
  const SightCostFunction<Cost>* end_;
  const SightContext& context_;
};

}  // namespace plslam
