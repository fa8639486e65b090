// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/robust.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plslam {
namespace {

constexpr int kIntervals = 32;

// Density of the norm of a Gaussian vector of `dimension` 2, 3 or 4.
double ChiDensity(int dimension, double s) {
  const double tail = std::exp(-0.5 * s * s);
  if (dimension == 2) return s * tail;
  if (dimension == 3) return std::sqrt(2.0 / std::numbers::pi) * s * s * tail;
  return 0.5 * s * s * s * tail;
}

RobustExpectation Integrate(int dimension, double delta, double gate) {
  RobustExpectation sum;
  const double step = gate / kIntervals;
  for (int i = 0; i <= kIntervals; ++i) {
    const double s = step * i;
    const double simpson = i == 0 || i == kIntervals ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    const double mass = simpson * step / 3.0 * ChiDensity(dimension, s);
    const double w = PseudoHuberWeight(s * s, delta);
    sum.probability += mass;
    sum.weight += mass * w;
    sum.A += mass * w * s * s / dimension;
    sum.B += mass * w * w * s * s / dimension;
  }
  return sum;
}

}  // namespace

double ChiSquareQuantile(int dimension, double z) {
  const double spread = 2.0 / (9.0 * dimension);
  const double root = std::max(0.0, 1.0 - spread + z * std::sqrt(spread));
  return dimension * root * root * root;
}

double Median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

RobustExpectations ExpectRobust(double delta, double gate_sigmas) {
  RobustExpectations table;
  for (int dimension = 2; dimension <= 4; ++dimension) {
    table[dimension] = Integrate(dimension, delta, std::sqrt(ChiSquareQuantile(dimension, gate_sigmas)));
  }
  return table;
}

}  // namespace plslam
