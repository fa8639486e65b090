// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/pose_graph/pose_graph_marginals.h"

#include <gtest/gtest.h>

#include <random>

#include <Eigen/LU>

namespace plslam {
namespace {

// Sparse and positive definite: J^T J of random rows with few elements, and a little on the diagonal.
Eigen::SparseMatrix<double> RandomMatrix(int n, int rows, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  Eigen::MatrixXd dense = 0.01 * Eigen::MatrixXd::Identity(n, n);
  for (int i = 0; i < rows; ++i) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    for (int k = 0; k < 4; ++k) row[static_cast<int>(random() % n)] = value(random);
    dense += row * row.transpose();
  }
  return dense.triangularView<Eigen::Lower>().toDenseMatrix().sparseView();
}

TEST(SelectedInverse, ElementsAreThoseOfTheDenseInverse) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const int n = 5 + 7 * static_cast<int>(seed);
    const Eigen::SparseMatrix<double> lower = RandomMatrix(n, n, seed);
    const Eigen::MatrixXd dense = Eigen::MatrixXd(lower).selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd expected = dense.inverse();
    const SelectedInverse inverse(lower);
    ASSERT_TRUE(inverse.ok());
    for (int column = 0; column < n; ++column) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(lower, column); it; ++it) {
        const int row = static_cast<int>(it.row());
        EXPECT_NEAR(inverse(row, column), expected(row, column), 1e-9 * expected.norm()) << seed;
        EXPECT_EQ(inverse(row, column), inverse(column, row));
      }
    }
  }
}

TEST(SelectedInverse, NothingAndOneNumber) {
  EXPECT_TRUE(SelectedInverse(Eigen::SparseMatrix<double>(0, 0)).ok());
  Eigen::SparseMatrix<double> one(1, 1);
  one.insert(0, 0) = 4.0;
  EXPECT_EQ(SelectedInverse(one)(0, 0), 0.25);
}

TEST(SelectedInverse, MatricesThatAreNotPositiveDefiniteAreSaidToBe) {
  Eigen::SparseMatrix<double> matrix(2, 2);
  matrix.insert(0, 0) = 1.0;
  matrix.insert(1, 0) = 2.0;
  matrix.insert(1, 1) = 1.0;
  EXPECT_FALSE(SelectedInverse(matrix).ok());
  EXPECT_FALSE(SelectedInverse(Eigen::SparseMatrix<double>(3, 3)).ok());
}

}  // namespace
}  // namespace plslam
