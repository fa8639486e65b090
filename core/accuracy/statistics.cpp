// SPDX-License-Identifier: BSD-3-Clause
#include "core/accuracy/statistics.h"

#include <algorithm>
#include <cmath>

namespace plslam {

Statistics Summarise(std::vector<double> values) {
  Statistics result;
  if (values.empty()) return result;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const double value : values) {
    sum += value;
    sum_of_squares += value * value;
  }
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  result.n = static_cast<int>(n);
  result.rmse = std::sqrt(sum_of_squares / static_cast<double>(n));
  result.mean = sum / static_cast<double>(n);
  result.median = 0.5 * (values[(n - 1) / 2] + values[n / 2]);
  result.max = values.back();
  return result;
}

double ChiSquareQuantile(double degrees_of_freedom, double z) {
  const double k = 2.0 / (9.0 * degrees_of_freedom);
  return degrees_of_freedom * std::pow(1.0 - k + z * std::sqrt(k), 3);
}

}  // namespace plslam
