// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/se3.h"

namespace plslam {

/// Small symmetric systems, compiled once for all sources: the templates of one factorisation take seconds
/// to compile. symmetric.cpp names the sizes `N` that exist. Only the lower triangle is read.
template <int N>
using SquareMatrix = Eigen::Matrix<double, N, N>;
template <int N>
using Column = Eigen::Matrix<double, N, 1>;

/// Returns x with A x = b by LDL^T with pivoting; values that are not finite if A is not of full rank.
template <int N>
Column<N> SolveSymmetric(const SquareMatrix<N>& A, const Column<N>& b);

/// Returns e^T covariance^-1 e; not finite, or negative, if the covariance is not positive definite.
template <int N>
double SquaredMahalanobis(const Column<N>& e, const SquareMatrix<N>& covariance) {
  return e.dot(SolveSymmetric<N>(covariance, e));
}

/// Returns whether all pivots of a Cholesky factorisation are positive.
template <int N>
bool IsPositiveDefinite(const SquareMatrix<N>& A);

/// Returns A^-1 by a Cholesky factorisation; A must be positive definite.
template <int N>
SquareMatrix<N> InverseOfPositiveDefinite(const SquareMatrix<N>& A);

/// Returns L with A = L L^T, lower triangular; nullopt if A is not positive definite.
template <int N>
std::optional<SquareMatrix<N>> CholeskyFactor(const SquareMatrix<N>& A);

/// Eigenvalues in increasing order; the columns of `vectors` are the unit eigenvectors.
template <int N>
struct SymmetricEigen {
  Column<N> values;
  SquareMatrix<N> vectors;
};
template <int N>
SymmetricEigen<N> EigenOf(const SquareMatrix<N>& A);

}  // namespace plslam
