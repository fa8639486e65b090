// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/lap_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/geometry/similarity.h"

namespace plslam::test {

std::vector<double> ErrorsOfLaps(const std::vector<SE3>& estimated, const std::vector<SE3>& truth, size_t lap) {
  const auto two = static_cast<std::ptrdiff_t>(std::min(2 * lap, truth.size()));
  const SE3 T_estimated_truth =
      AlignPaths({estimated.begin(), estimated.begin() + two}, {truth.begin(), truth.begin() + two}, false).T_a_b;
  std::vector<double> errors_m;
  for (size_t first = 0; first + lap <= truth.size(); first += lap) {
    double sum_m2 = 0.0;
    for (size_t i = first; i < first + lap; ++i) {
      sum_m2 += (T_estimated_truth * truth[i].translation() - estimated[i].translation()).squaredNorm();
    }
    errors_m.push_back(std::sqrt(sum_m2 / static_cast<double>(lap)));
  }
  return errors_m;
}

double MeanOfLast(const std::vector<double>& values, size_t n) {
  const auto first = values.end() - static_cast<std::ptrdiff_t>(n);
  return std::accumulate(first, values.end(), 0.0) / static_cast<double>(n);
}

}  // namespace plslam::test
