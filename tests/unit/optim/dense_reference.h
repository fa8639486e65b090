// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/optim/bundle/bundle.h"

namespace plslam::test {

/// The slow twin of AdjustBundle for points and for lines by four parameters: one dense system with numeric Jacobians,
/// solved by Levenberg-Marquardt until convergence, without outlier removal.
struct DenseResult {
  std::vector<SE3> T_w_c;
  std::vector<Eigen::Vector3d> points;
  std::vector<Segment3> lines;
  /// Half the sum of losses.
  double cost = 0.0;
  /// Inverse of the weighted information, right perturbations of free poses first, then positions, then lines.
  Eigen::MatrixXd covariance;
};

DenseResult AdjustDense(const BundleProblem& problem, double huber_delta);

}  // namespace plslam::test
