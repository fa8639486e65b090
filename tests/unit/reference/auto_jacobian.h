// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <utility>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <Eigen/Core>

namespace plslam::test {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Residuals of a functor with two parameter blocks, and their Jacobians by automatic derivatives.
struct AutoEvaluation {
  bool ok = false;
  Eigen::VectorXd r;
  RowMajor by_first;
  RowMajor by_second;
};

template <int kFirst, int kSecond, class Functor>
AutoEvaluation Differentiate(const Functor& functor, int rows, const double* first, const double* second) {
  ceres::AutoDiffCostFunction<Functor, ceres::DYNAMIC, kFirst, kSecond> cost(new Functor(functor), rows);  // NOLINT
  AutoEvaluation result{false, Eigen::VectorXd(rows), RowMajor(rows, kFirst), RowMajor(rows, kSecond)};
  const double* parameters[] = {first, second};
  double* jacobians[] = {result.by_first.data(), result.by_second.data()};
  result.ok = cost.Evaluate(parameters, result.r.data(), jacobians);
  return result;
}

}  // namespace plslam::test
