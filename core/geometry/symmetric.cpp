// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/symmetric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace plslam {

template <int N>
Column<N> SolveSymmetric(const SquareMatrix<N>& A, const Column<N>& b) {
  return A.ldlt().solve(b);
}

template <int N>
bool IsPositiveDefinite(const SquareMatrix<N>& A) {
  return A.llt().info() == Eigen::Success;
}

template <int N>
SquareMatrix<N> InverseOfPositiveDefinite(const SquareMatrix<N>& A) {
  return A.llt().solve(SquareMatrix<N>::Identity());
}

template <int N>
std::optional<SquareMatrix<N>> CholeskyFactor(const SquareMatrix<N>& A) {
  const Eigen::LLT<SquareMatrix<N>> cholesky(A);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  return SquareMatrix<N>(cholesky.matrixL());
}

template <int N>
SymmetricEigen<N> EigenOf(const SquareMatrix<N>& A) {
  const Eigen::SelfAdjointEigenSolver<SquareMatrix<N>> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template Column<2> SolveSymmetric<2>(const SquareMatrix<2>&, const Column<2>&);
template Column<3> SolveSymmetric<3>(const SquareMatrix<3>&, const Column<3>&);
template Column<6> SolveSymmetric<6>(const SquareMatrix<6>&, const Column<6>&);
template bool IsPositiveDefinite<3>(const SquareMatrix<3>&);
template bool IsPositiveDefinite<4>(const SquareMatrix<4>&);
template bool IsPositiveDefinite<6>(const SquareMatrix<6>&);
template SquareMatrix<3> InverseOfPositiveDefinite<3>(const SquareMatrix<3>&);
template SquareMatrix<6> InverseOfPositiveDefinite<6>(const SquareMatrix<6>&);

template std::optional<SquareMatrix<3>> CholeskyFactor<3>(const SquareMatrix<3>&);
template std::optional<SquareMatrix<6>> CholeskyFactor<6>(const SquareMatrix<6>&);
template SymmetricEigen<3> EigenOf<3>(const SquareMatrix<3>&);
template SymmetricEigen<6> EigenOf<6>(const SquareMatrix<6>&);

}  // namespace plslam
