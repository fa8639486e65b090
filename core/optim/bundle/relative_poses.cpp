// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/relative_poses.h"

#include <Eigen/Cholesky>

#include <cmath>

#include "core/motion/robust.h"

namespace plslam {
namespace {

using Jacobian = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

// Derivative of the right perturbation of a pose by its parameters [a; w].
Matrix6d PerturbationByParameters(const AdjustedPose& pose) {
  Matrix6d by = Matrix6d::Zero();
  by.topLeftCorner<3, 3>() = pose.view.R_c_w;
  by.bottomRightCorner<3, 3>() = pose.view.turn;
  return by;
}

// Inverse right Jacobian of SE(3) for a small difference, to first order: I + ad(e) / 2.
Matrix6d InverseRightJacobian(const Vector6d& e) {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = Skew(e.tail<3>());
  ad.topRightCorner<3, 3>() = Skew(e.head<3>());
  ad.bottomRightCorner<3, 3>() = Skew(e.tail<3>());
  return Matrix6d::Identity() + 0.5 * ad;
}

}  // namespace

RelativePoseCost::RelativePoseCost(const RelativePose& measured, AdjustedPose& a, AdjustedPose& b)
    : T_b_a_measured_(measured.T_a_b.Inverse()), a_(&a), b_(&b) {
  const Eigen::LLT<Matrix6d> cholesky(measured.covariance);
  const bool definite = measured.covariance.allFinite() && cholesky.info() == Eigen::Success;
  if (definite) whitening_ = cholesky.matrixL().solve(Matrix6d::Identity());
  usable_ = definite && whitening_.allFinite() && measured.T_a_b.IsFinite() && (a.IsFree() || b.IsFree()) && &a != &b;
}

void RelativePoseCost::Evaluate(double* residuals, double* by_a, double* by_b) const {
  const SE3 T_a_b = a_->T_w_c().Inverse() * b_->T_w_c();
  const Vector6d difference = (T_b_a_measured_ * T_a_b).Log();
  Eigen::Map<Vector6d>{residuals} = whitening_ * difference;
  if (by_a == nullptr && by_b == nullptr) return;
  const Matrix6d by_perturbation = whitening_ * InverseRightJacobian(difference);
  if (by_a != nullptr) {
    Eigen::Map<Jacobian>{by_a} = -by_perturbation * T_a_b.Inverse().Adjoint() * PerturbationByParameters(*a_);
  }
  if (by_b != nullptr) Eigen::Map<Jacobian>{by_b} = by_perturbation * PerturbationByParameters(*b_);
}

RelativePoses::RelativePoses(const std::vector<RelativePose>& measured, std::vector<AdjustedPose>& poses) {
  for (const RelativePose& relative : measured) {
    AdjustedPose& a = poses[static_cast<size_t>(relative.a)];
    AdjustedPose& b = poses[static_cast<size_t>(relative.b)];
    if (a.observations == 0 || b.observations == 0) continue;
    const RelativePoseCost cost(relative, a, b);
    if (cost.IsUsable()) costs_.push_back(cost);
  }
}

double RelativePoses::Linearise(PoseSystem& system) const {
  using ByPose = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  double loss = 0.0;
  Vector6d r;
  ByPose by_a;
  ByPose by_b;
  for (const RelativePoseCost& cost : costs_) {
    cost.Evaluate(r.data(), by_a.data(), by_b.data());
    const double squared = r.squaredNorm();
    loss += PseudoHuberLoss(squared, kDelta);
    const double weight = PseudoHuberWeight(squared, kDelta);
    const int a = cost.a().column;
    const int b = cost.b().column;
    if (a >= 0) {
      system.Diagonal(a).noalias() += weight * by_a.transpose() * by_a;
      system.Gradient(a).noalias() += weight * by_a.transpose() * r;
    }
    if (b >= 0) {
      system.Diagonal(b).noalias() += weight * by_b.transpose() * by_b;
      system.Gradient(b).noalias() += weight * by_b.transpose() * r;
    }
    if (a < 0 || b < 0) continue;
    if (a < b) {
      system.Below(a, b).noalias() += weight * by_b.transpose() * by_a;
    } else {
      system.Below(b, a).noalias() += weight * by_a.transpose() * by_b;
    }
  }
  return loss;
}

void RelativePoses::HoldPoses() {
  for (const RelativePoseCost& cost : costs_) cost.a().constant = cost.b().constant = true;
}

double RelativePoses::Loss() const {
  double loss = 0.0;
  Vector6d r;
  for (const RelativePoseCost& cost : costs_) {
    cost.Evaluate(r.data(), nullptr, nullptr);
    loss += PseudoHuberLoss(r.squaredNorm(), kDelta);
  }
  return loss;
}

}  // namespace plslam
