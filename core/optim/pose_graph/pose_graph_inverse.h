#pragma once

#include <vector>

#include <Eigen/SparseCholesky>

namespace plslam {

/// Chosen elements of the inverse of a sparse symmetric positive definite matrix, without the rest of it: those where the
/// matrix itself, or its Cholesky factor L D L^T, has an element. Recursion from the last column to the first
/// (Takahashi, Fagan, Chin 1973): Z = D^-1 L^-1 + (I - L^T) Z, in which each column needs only chosen elements of later
/// ones. Costs about as much as the factorisation.
class SelectedInverse {
 public:
  /// Of the lower triangle of a symmetric matrix.
  explicit SelectedInverse(const Eigen::SparseMatrix<double>& lower);

  /// False where the matrix is not positive definite; there are no elements then.
  bool ok() const { return ok_; }

  /// Where the matrix has an element of its own, or on the diagonal.
  double operator()(int row, int column) const;

 private:
  void Fill();

  using Sparse = Eigen::SparseMatrix<double>;
  Eigen::SimplicialLDLT<Sparse> factor_;
  bool ok_ = false;
  std::vector<double> diagonal_;
  /// Beside the elements of L.
  std::vector<double> below_;
};

}  // namespace plslam
