// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace plslam {

/// Summary of non-negative errors. All zero where there are none (`n` tells).
struct Statistics {
  int n = 0;
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< mean of the two middle values where `n` is even
  double max = 0.0;
};

Statistics Summarise(std::vector<double> values);

/// Quantile of the chi-square distribution by the approximation of Wilson and Hilferty (1931), for the two-sided 95 %
/// interval: `z` is +-1.959964. Off by less than 3 % at 6 degrees of freedom and 0.1 % from 60 on.
double ChiSquareQuantile(double degrees_of_freedom, double z);

}  // namespace plslam
