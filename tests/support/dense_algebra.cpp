// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/dense_algebra.h"

#include <Eigen/Cholesky>

namespace plslam::test {

double ChiSquare(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  return error.dot(covariance.ldlt().solve(error));
}

Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& J, const Eigen::VectorXd& r) {
  return (J.transpose() * J).ldlt().solve(J.transpose() * r);
}

}  // namespace plslam::test
