// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace plslam {

/// Levenberg-Marquardt damping: each diagonal element of the information grows by this share of itself.
struct Damping {
  double share = 0.0;

  /// Returns the damping for the diagonal of an information matrix.
  template <class Diagonal>
  Eigen::Matrix<double, Diagonal::RowsAtCompileTime, 1> Of(const Diagonal& diagonal) const {
    // Bounds as in Ceres.
    return share * diagonal.array().max(1e-6).min(1e32);
  }
};

/// Trust region as in Ceres: K. Madsen, H. B. Nielsen, O. Tingleff, "Methods for non-linear least squares problems"
/// (2004), 3.2. The damping is 1 / radius.
class TrustRegion {
 public:
  Damping damping() const { return {1.0 / radius_}; }
  /// `gain_ratio`: actual reduction of the loss over the predicted one.
  void Accepted(double gain_ratio) {
    radius_ = std::min(1e16, radius_ / std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain_ratio - 1.0, 3)));
    shrink_ = 2.0;
  }
  void Rejected() {
    radius_ /= shrink_;
    shrink_ *= 2.0;
  }

  /// Least gain ratio of an accepted step.
  static constexpr double kMinGainRatio = 1e-3;
  /// Consecutive rejected steps without predicted reduction after which the solver stops.
  static constexpr int kMaxWithoutStep = 5;

 private:
  double radius_ = 1e4;
  double shrink_ = 2.0;
};

}  // namespace plslam
