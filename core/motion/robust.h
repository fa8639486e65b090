// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace plslam {

/// Pseudo-Huber loss 2 d^2 (sqrt(1 + s^2 / d^2) - 1) of the squared norm s^2 of a whitened residual vector.
inline double PseudoHuberLoss(double squared, double delta) {
  // This form of sqrt(1 + x) - 1 avoids cancellation near zero.
  return 2.0 * squared / (std::sqrt(1.0 + squared / (delta * delta)) + 1.0);
}

/// Derivative of the loss by s^2: the weight of iteratively reweighted least squares, 1 at zero.
inline double PseudoHuberWeight(double squared, double delta) {
  return 1.0 / std::sqrt(1.0 + squared / (delta * delta));
}

/// Returns the quantile of the chi-square distribution at the normal quantile `z` (0: the median; 2.33: 99 %), by
/// Wilson and Hilferty's cube; accurate to 1 % for 2 and more degrees of freedom.
double ChiSquareQuantile(int dimension, double z);

/// Returns the middle element, the upper one of an even number; 0 for none. Reorders its argument.
double Median(std::vector<double>& values);

/// Expectations over s < gate of Gaussian residuals of one dimension with pseudo-Huber weights w, cut off at a gate.
/// They turn the inverse weighted Hessian into a consistent covariance (M-estimator theory: the covariance is
/// A^-1 B A^-1 with A = E[w s^2] / dim by Stein's identity, and B = E[w^2 s^2] / dim).
struct RobustExpectation {
  double probability = 0.0;
  double weight = 0.0;
  double A = 0.0;
  double B = 0.0;
};

/// Indexed by dimension, 2 to 4.
using RobustExpectations = std::array<RobustExpectation, 5>;

RobustExpectations ExpectRobust(double delta, double gate_sigmas);

}  // namespace plslam
