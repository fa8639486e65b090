// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/ceres.h>

#include "core/optim/pose_graph/pose_graph_group.h"

namespace plslam {

/// Right perturbations as Ceres wants them. Costs give derivatives by the perturbation itself, in the first columns,
/// so that the derivative of Plus is those columns' identity and no product loses digits.
template <class Pose>
class PoseManifold : public ceres::Manifold {
 public:
  using Group = PoseGroup<Pose>;
  static constexpr int kFreedom = kPoseFreedom<Pose>;

  int AmbientSize() const override { return Group::kParameters; }
  int TangentSize() const override { return kFreedom; }

  bool Plus(const double* x, const double* step, double* x_plus_step) const override {
    Group::Store(Group::Plus(Group::Load(x), step), x_plus_step);
    return true;
  }

  bool PlusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, Group::kParameters, kFreedom, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }

  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Eigen::Map<Eigen::Matrix<double, kFreedom, 1>>{y_minus_x} = Group::Minus(Group::Load(y), Group::Load(x));
    return true;
  }

  bool MinusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kFreedom, Group::kParameters, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

/// Whitened error of an edge: its squared norm is the edge's chi-square.
template <class Pose>
class PoseGraphCost : public ceres::SizedCostFunction<kPoseFreedom<Pose>, PoseGroup<Pose>::kParameters,
                                                      PoseGroup<Pose>::kParameters> {
 public:
  using Group = PoseGroup<Pose>;
  static constexpr int kFreedom = kPoseFreedom<Pose>;

  /// The information must be positive definite.
  explicit PoseGraphCost(const PoseGraphMotion<Pose>& edge)
      : T_a_b_(edge.T_a_b), whitening_(edge.information.llt().matrixU()) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const PoseEdgeError<Pose> error = Group::Error(T_a_b_, Group::Load(parameters[0]), Group::Load(parameters[1]));
    Eigen::Map<Eigen::Matrix<double, kFreedom, 1>>{residuals} = whitening_ * error.e;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) Write(whitening_ * error.by_a, jacobians[0]);
    if (jacobians[1] != nullptr) Write(whitening_ * error.by_b, jacobians[1]);
    return true;
  }

 private:
  static void Write(const PoseMatrix<Pose>& by_perturbation, double* jacobian) {
    Eigen::Map<Eigen::Matrix<double, kFreedom, Group::kParameters, Eigen::RowMajor>> out(jacobian);
    out.setZero();
    out.template leftCols<kFreedom>() = by_perturbation;
  }

  Pose T_a_b_;
  PoseMatrix<Pose> whitening_;
};

}  // namespace plslam
