// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace plslam {

/// Levenberg and Marquardt's damping: each diagonal element of the information grows by this share of itself.
struct Damping {
  double share = 0.0;

  /// Of the diagonal of an information.
  template <class Diagonal>
  Eigen::Matrix<double, Diagonal::RowsAtCompileTime, 1> Of(const Diagonal& diagonal) const {
    // Bounds as those of Ceres.
    return share * diagonal.array().max(1e-6).min(1e32);
  }
};

/// How far steps are trusted, as Ceres has it: K. Madsen, H. B. Nielsen, O. Tingleff, "Methods for non-linear least
/// squares problems" (2004), 3.2.
class TrustRegion {
 public:
  Damping damping() const { return {1.0 / radius_}; }
  /// `gain_ratio`: gain of the step over the predicted one.
  void Accepted(double gain_ratio) {
    radius_ = std::min(1e16, radius_ / std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain_ratio - 1.0, 3)));
    shrink_ = 2.0;
  }
  void Rejected() {
    radius_ /= shrink_;
    shrink_ *= 2.0;
  }

  /// A gain below this share of the predicted one is none.
  static constexpr double kMinGainRatio = 1e-3;
  /// Steps in a row that were none, after which there is nothing to gain.
  static constexpr int kMaxWithoutStep = 5;

 private:
  double radius_ = 1e4;
  double shrink_ = 2.0;
};

}  // namespace plslam
