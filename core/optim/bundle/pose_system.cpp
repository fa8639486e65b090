// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/pose_system.h"

#include <Eigen/Cholesky>

#include "core/optim/solver/dense_blocks.h"

namespace plslam {

PoseSystem::PoseSystem(int pose_count, Storage storage)
    : is_dense_(storage == Storage::kDense),
      g_(Eigen::VectorXd::Zero(6 * pose_count)),
      blocks_(is_dense_ ? 0 : pose_count) {
  if (is_dense_) H_.setZero(6 * pose_count, 6 * pose_count);
}

void PoseSystem::SetZero() {
  H_.setZero();
  blocks_.SetZero();
  g_.setZero();
}

void PoseSystem::Assign(const PoseSystem& other) {
  g_ = other.g_;
  H_ = other.H_;
  blocks_.Assign(other.blocks_);
}

Eigen::VectorXd PoseSystem::DiagonalValues() const {
  if (is_dense_) return H_.diagonal();
  Eigen::VectorXd values(g_.size());
  for (size_t i = 0; i < blocks_.diagonal.size(); ++i) {
    values.segment<6>(6 * static_cast<Eigen::Index>(i)) = blocks_.diagonal[i].diagonal();
  }
  return values;
}

void PoseSystem::AddToDiagonal(const Eigen::VectorXd& values) {
  if (is_dense_) {
    H_.diagonal() += values;
    return;
  }
  for (size_t i = 0; i < blocks_.diagonal.size(); ++i) {
    blocks_.diagonal[i].diagonal() += values.segment<6>(6 * static_cast<Eigen::Index>(i));
  }
}

std::optional<Eigen::VectorXd> PoseSystem::Solve() {
  if (g_.size() == 0) return g_;
  if (is_dense_) {
    UseEqualDenseBlocks();
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> root(H_);
    if (root.info() != Eigen::Success) return std::nullopt;
    return -root.solve(g_);
  }
  if (!cholesky_.Factorise(blocks_)) return std::nullopt;
  return -cholesky_.Solve(g_);
}

}  // namespace plslam
