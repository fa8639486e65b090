// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/quantile_sketch.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

constexpr double kSmallest = 1e-4;
const double kLogRatio = std::log(1.01);

}  // namespace

void QuantileSketch::Add(double value) {
  if (!std::isfinite(value)) return;
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  const double bin = value > kSmallest ? std::floor(std::log(value / kSmallest) / kLogRatio) : 0.0;
  ++bins_[static_cast<size_t>(std::clamp(bin, 0.0, static_cast<double>(kBins - 1)))];
  ++count_;
}

double QuantileSketch::Quantile(double q) const {
  if (count_ == 0) return 0.0;
  const auto rank = std::clamp<int64_t>(std::llround(std::ceil(q * static_cast<double>(count_))), 1, count_);
  int64_t seen = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen >= rank) return std::clamp(kSmallest * std::exp((bin + 0.5) * kLogRatio), min_, max_);
  }
  return max_;
}

}  // namespace plslam
