// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/run_counters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plslam {
namespace {

// More are invented.
constexpr size_t kMaxValues = 4096;

template <class Names>
bool Has(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Whether it is an estimate, of which only the newest one counts.
bool IsEstimate(const std::string& name) {
  constexpr std::array kEstimates{kImuInnovation, kImuDelay, kImuDelaySigma, kImuRateBiasSigma, kImuForceBiasSigma};
  return Has(kEstimates, name) || Has(kImuRateBias, name) || Has(kImuForceBias, name);
}

}  // namespace

void RunCounters::Take(SourceId source, const std::string& name, double value) {
  if (!std::isfinite(value)) return;
  if (IsEstimate(name)) {
    newest_[name] = value;
    return;
  }
  if (!Has(kRunCounters, name) || value < 0.0) return;
  const std::pair key(name, source);
  if (values_.size() >= kMaxValues && !values_.contains(key)) return;
  values_[key] = value;
}

std::optional<double> RunCounters::Newest(std::string_view name) const {
  const auto found = newest_.find(name);
  return found == newest_.end() ? std::nullopt : std::optional(found->second);
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

std::optional<ImuFigures> ImuFiguresOf(const RunCounters& counters) {
  const std::optional<double> innovation = counters.Newest(kImuInnovation);
  if (!innovation) return std::nullopt;
  const auto newest = [&](const char* name) { return counters.Newest(name).value_or(0.0); };
  ImuFigures figures;
  figures.used_frames = static_cast<int64_t>(counters.Sum(kImuUsed));
  figures.innovation = *innovation;
  if (newest(kImuDelaySigma) > 0.0) figures.delay = {newest(kImuDelay), newest(kImuDelaySigma)};
  std::transform(kImuRateBias.begin(), kImuRateBias.end(), figures.rate_bias_rad_s.begin(), newest);
  std::transform(kImuForceBias.begin(), kImuForceBias.end(), figures.force_bias_m_s2.begin(), newest);
  figures.rate_bias_sigma_rad_s = newest(kImuRateBiasSigma);
  figures.force_bias_sigma_m_s2 = newest(kImuForceBiasSigma);
  return figures;
}

}  // namespace plslam
