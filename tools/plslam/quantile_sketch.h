// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace plslam {

/// Median and other quantiles of positive numbers in fixed memory, however many there are: a histogram whose bins
/// grow by 1 %, so that a quantile is within 0.5 % of the exact one (for values of 1e-4 to 1e6; others are clamped).
class QuantileSketch {
 public:
  void Add(double value);
  int64_t count() const { return count_; }
  /// The value below which a share of `q` (0 to 1) of the numbers lies (nearest rank); 0 without numbers.
  double Quantile(double q) const;

 private:
  static constexpr int kBins = 2320;  // 1e-4 * 1.01^2320 > 1e6

  std::array<int64_t, kBins> bins_{};
  int64_t count_ = 0;
  double min_ = 0.0;
  double max_ = 0.0;
};

}  // namespace plslam
