// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace plslam::test {

// Compiled once: Eigen's factorisations take seconds in every source that has one.

/// Returns error^T covariance^-1 error: chi-square distributed, with the degrees of freedom of the error's size, if the
/// covariance is correct.
double ChiSquare(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance);

/// The x at which |J x - r| is smallest, by the normal equations.
Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& J, const Eigen::VectorXd& r);

}  // namespace plslam::test
