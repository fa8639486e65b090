// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/solver/block_cholesky.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <random>

#include "core/geometry/se3.h"

namespace plslam {
namespace {

/// Positive definite: each pose is tied to some of those before it, and held a little.
SymmetricBlocks<6> Tied(int size, int neighbours, int loops, uint32_t seed) {
  std::mt19937 random(seed);
  const auto draw = [&random] {
    Matrix6d block;
    for (double& value : block.reshaped()) value = static_cast<double>(random() % 2001) * 1e-3 - 1.0;
    return block;
  };
  SymmetricBlocks<6> matrix(size);
  for (Matrix6d& block : matrix.diagonal) block.setIdentity();
  const auto tie = [&](int a, int b) {
    const Matrix6d J_a = draw();
    const Matrix6d J_b = draw();
    matrix.diagonal[static_cast<size_t>(a)] += J_a.transpose() * J_a;
    matrix.diagonal[static_cast<size_t>(b)] += J_b.transpose() * J_b;
    matrix.Below(a, b) += J_b.transpose() * J_a;
  };
  for (int i = 1; i < size; ++i) {
    for (int k = std::max(0, i - neighbours); k < i; ++k) tie(k, i);
  }
  for (int i = 0; i < loops; ++i) {
    const auto a = static_cast<int>(random() % static_cast<uint32_t>(size));
    const auto b = static_cast<int>(random() % static_cast<uint32_t>(size));
    if (a != b) tie(std::min(a, b), std::max(a, b));
  }
  return matrix;
}

Eigen::MatrixXd Dense(const SymmetricBlocks<6>& matrix) {
  const auto n = static_cast<Eigen::Index>(matrix.rows.size());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  for (Eigen::Index row = 0; row < n; ++row) {
    dense.block<6, 6>(6 * row, 6 * row) = matrix.diagonal[static_cast<size_t>(row)];
    for (const auto& [column, place] : matrix.rows[static_cast<size_t>(row)]) {
      dense.block<6, 6>(6 * row, 6 * column) = matrix.below[place];
      dense.block<6, 6>(6 * column, 6 * row) = matrix.below[place].transpose();
    }
  }
  return dense;
}

TEST(BlockCholesky, AgreesWithADenseSolve) {
  for (const auto& [size, neighbours, loops] :
       {std::tuple{1, 0, 0}, {2, 1, 0}, {30, 3, 0}, {40, 5, 12}, {25, 24, 0}}) {
    const SymmetricBlocks<6> matrix = Tied(size, neighbours, loops, static_cast<uint32_t>(size));
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(6 * size, -1.0, 2.0);
    BlockCholesky<6> cholesky;
    ASSERT_TRUE(cholesky.Factorise(matrix));
    const Eigen::VectorXd expected = Dense(matrix).llt().solve(b);
    EXPECT_LT((cholesky.Solve(b) - expected).norm(), 1e-9 * expected.norm()) << size << " blocks";
  }
}

TEST(BlockCholesky, FollowsChangedValuesAndNewBlocks) {
  SymmetricBlocks<6> matrix = Tied(30, 3, 0, 1);
  BlockCholesky<6> cholesky;
  ASSERT_TRUE(cholesky.Factorise(matrix));
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(180);
  const auto check = [&] {
    ASSERT_TRUE(cholesky.Factorise(matrix));
    const Eigen::VectorXd expected = Dense(matrix).llt().solve(b);
    EXPECT_LT((cholesky.Solve(b) - expected).norm(), 1e-9 * expected.norm());
  };
  matrix.diagonal[7] *= 2.0;
  check();
  matrix.Below(2, 28) = 0.1 * Matrix6d::Identity();
  check();
}

TEST(BlockCholesky, AChainIsNotFilled) {
  BlockCholesky<6> cholesky;
  ASSERT_TRUE(cholesky.Factorise(Tied(500, 1, 0, 2)));
  EXPECT_EQ(cholesky.size(), 499U);
  ASSERT_TRUE(cholesky.Factorise(Tied(500, 1, 3, 2)));
  EXPECT_LT(cholesky.size(), 998U) << "a ring needs one more block for each row";
}

TEST(BlockCholesky, RefusesIndefiniteMatrices) {
  SymmetricBlocks<6> matrix = Tied(20, 2, 0, 3);
  matrix.diagonal[11](4, 4) = -1.0;
  BlockCholesky<6> cholesky;
  EXPECT_FALSE(cholesky.Factorise(matrix));
  matrix.diagonal[11].setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(cholesky.Factorise(matrix));
}

TEST(SymmetricBlocks, CopyTheValuesOfAnother) {
  SymmetricBlocks<6> larger = Tied(10, 3, 0, 4);
  const SymmetricBlocks<6> smaller = Tied(10, 1, 0, 5);
  larger.Assign(smaller);
  EXPECT_EQ(Dense(larger), Dense(smaller));
  EXPECT_GT(larger.below.size(), smaller.below.size());
}

TEST(BlockCholesky, BlocksOfTheInverseAgreeWithDense) {
  for (const auto& [size, neighbours, loops] : {std::tuple{1, 0, 0}, {30, 3, 0}, {40, 5, 12}, {25, 24, 0}}) {
    const SymmetricBlocks<6> matrix = Tied(size, neighbours, loops, static_cast<uint32_t>(size));
    BlockCholesky<6> cholesky;
    ASSERT_TRUE(cholesky.Factorise(matrix));
    cholesky.Invert();
    const Eigen::MatrixXd expected = Dense(matrix).inverse();
    for (int row = 0; row < size; ++row) {
      std::vector<int> columns{row};
      for (const auto& [column, place] : matrix.rows[static_cast<size_t>(row)]) columns.push_back(column);
      for (const int column : columns) {
        const Matrix6d block = cholesky.Inverse(row, column);
        EXPECT_LT((block - expected.block<6, 6>(6 * row, 6 * column)).norm(), 1e-9 * expected.norm()) << size;
        EXPECT_EQ(block, cholesky.Inverse(column, row).transpose());
      }
    }
  }
}

TEST(BlockCholesky, InverseOfNothingAndFarFromTheDiagonal) {
  BlockCholesky<6> cholesky;
  ASSERT_TRUE(cholesky.Factorise(SymmetricBlocks<6>(0)));
  cholesky.Invert();
  ASSERT_TRUE(cholesky.Factorise(Tied(12, 1, 0, 3)));
  cholesky.Invert();
  EXPECT_TRUE(cholesky.Inverse(11, 0).isZero(0.0)) << "is not computed";
}

}  // namespace
}  // namespace plslam
