// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/reduced_information.h"

#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include "core/optim/solver/dense_blocks.h"

namespace plslam {
namespace {

// Number of poses above which a dense inverse takes more time and memory than sparse solves.
constexpr int kMaxDenselyInverted = 60;
constexpr double kUnseen_m = 1e3;
constexpr double kUnseen_rad = 20.0 * std::numbers::pi;

/// Covariance of a pose without observations.
Matrix6d Unseen() {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(kUnseen_m * kUnseen_m), Eigen::Vector3d::Constant(kUnseen_rad * kUnseen_rad);
  return variances.asDiagonal();
}

}  // namespace

ReducedInformation::ReducedInformation(int pose_count) : pose_count_(pose_count), rows_(pose_count) {
  const Matrix6d unseen = Unseen().diagonal().cwiseInverse().asDiagonal();
  for (int i = 0; i < pose_count; ++i) rows_[i][i] = unseen;
}

Matrix6d& ReducedInformation::Block(int i, int j) {
  const auto [entry, is_new] = rows_[i].try_emplace(j);
  if (is_new) entry->second.setZero();
  return entry->second;
}

std::vector<Matrix6d> ReducedInformation::Covariances() const {
  return pose_count_ <= kMaxDenselyInverted ? DenseCovariances() : SparseCovariances();
}

std::vector<Matrix6d> ReducedInformation::DenseCovariances() const {
  UseEqualDenseBlocks();
  const int n = 6 * pose_count_;
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < pose_count_; ++i) {
    // The factorisation reads the lower half.
    for (const auto& [j, block] : rows_[i]) full.block<6, 6>(6 * j, 6 * i) = block.transpose();
  }
  std::vector<Matrix6d> covariances(pose_count_, Unseen());
  const Eigen::LLT<Eigen::MatrixXd> factor(full);
  if (factor.info() != Eigen::Success) return covariances;
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(n, n));
  for (int i = 0; i < pose_count_; ++i) covariances[i] = inverse.block<6, 6>(6 * i, 6 * i);
  return covariances;
}

std::vector<Matrix6d> ReducedInformation::SparseCovariances() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < pose_count_; ++i) {
    for (const auto& [j, block] : rows_[i]) {
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < 6; ++c) entries.emplace_back(6 * j + c, 6 * i + r, block(r, c));
      }
    }
  }
  Eigen::SparseMatrix<double> lower(6 * pose_count_, 6 * pose_count_);
  lower.setFromTriplets(entries.begin(), entries.end());
  std::vector<Matrix6d> covariances(pose_count_, Unseen());
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(lower);
  if (factor.info() != Eigen::Success) return covariances;
  Eigen::Matrix<double, Eigen::Dynamic, 6> unit(6 * pose_count_, 6);
  for (int i = 0; i < pose_count_; ++i) {
    unit.setZero();
    unit.middleRows<6>(6 * i).setIdentity();
    const Eigen::Matrix<double, Eigen::Dynamic, 6> columns = factor.solve(unit);
    covariances[i] = columns.middleRows<6>(6 * i);
  }
  return covariances;
}

}  // namespace plslam
