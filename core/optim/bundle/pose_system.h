// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include <Eigen/Core>

#include "core/geometry/se3.h"

namespace plslam {

/// Normal equations H x = -g of the free poses, six rows for each. Only the lower triangle of H's blocks is kept.
struct PoseSystem {
  explicit PoseSystem(int pose_count)
      : H(Eigen::MatrixXd::Zero(6 * pose_count, 6 * pose_count)), g(Eigen::VectorXd::Zero(6 * pose_count)) {}

  void SetZero() {
    H.setZero();
    g.setZero();
  }

  auto Diagonal(int pose) { return H.block<6, 6>(6 * pose, 6 * pose); }
  auto Gradient(int pose) { return g.segment<6>(6 * pose); }
  /// Of two different poses, the later one's rows.
  auto Below(int earlier, int later) { return H.block<6, 6>(6 * later, 6 * earlier); }

  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};

}  // namespace plslam
