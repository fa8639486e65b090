// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/run_counters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace plslam {
namespace {

// More are invented.
constexpr size_t kMaxValues = 4096;

}  // namespace

void RunCounters::Take(SourceId source, const std::string& name, double value) {
  if (std::find(kRunCounters.begin(), kRunCounters.end(), name) == kRunCounters.end()) return;
  if (!std::isfinite(value) || value < 0.0) return;
  const std::pair key(name, source);
  if (values_.size() >= kMaxValues && !values_.contains(key)) return;
  values_[key] = value;
}

double RunCounters::Sum(std::string_view name) const {
  double sum = 0.0;
  for (const auto& [key, value] : values_) sum += key.first == name ? value : 0.0;
  return sum;
}

double RunCounters::Largest(std::string_view name) const {
  double largest = 0.0;
  for (const auto& [key, value] : values_) {
    if (key.first == name) largest = std::max(largest, value);
  }
  return largest;
}

}  // namespace plslam
