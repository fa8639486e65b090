// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/sample_checks.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace plslam {
namespace {

constexpr size_t kIntervals = 63;
constexpr size_t kFewestIntervals = 15;
// Samples of the fourth difference, and its variance for white noise of variance 1: 1 + 16 + 36 + 16 + 1.
constexpr size_t kScatterSamples = 5;
constexpr double kScatterVariance = 70.0;
constexpr double kFewestScatters = 50.0;
// Time over which forces are averaged: longer than a period of most vibrations, and short against turns.
constexpr double kForceBlock_s = 0.25;
constexpr double kForceBlocks = SampleChecks::kMemory_s / kForceBlock_s;
// Equal values in a row that a working sensor does not deliver.
constexpr int kStuckSamples = 10;
constexpr double kStuck_s = 0.1;
// Equal values in a row, at an extreme far outside the noise, that show the end of a range.
constexpr int kSaturatedRun = 3;
constexpr double kOutsideNoise = 10.0;
constexpr double kOutside_rad_s = 0.02;
constexpr double kOutside_m_s2 = 0.2;
constexpr int kFewestSaturated = 12;

}  // namespace

void SampleChecks::Add(const ImuSample& sample) {
  if (!newest_.empty() && sample.t_ns <= newest_.back().t_ns) return;
  Value value{sample.t_ns, {}};
  value.values << sample.rate_rad_s, sample.force_m_s2;
  if (!value.values.allFinite()) return;
  const double dt_s = newest_.empty() ? 0.0
                                      : 1e-9 * static_cast<double>(static_cast<uint64_t>(sample.t_ns) -
                                                                   static_cast<uint64_t>(newest_.back().t_ns));
  if (weight_ == 0.0) mean_ = most_ = least_ = value.values;
  const double kept = 1.0 / (1.0 + dt_s / kMemory_s);
  weight_ = kept * weight_ + 1.0;
  mean_ += (value.values - mean_) / weight_;
  most_weight_ *= kept;
  least_weight_ *= kept;
  if (!newest_.empty()) {
    AddForce(sample.force_m_s2, dt_s);
    CountInterval(dt_s);
    CountRuns(value, dt_s);
  }
  if (dt_s > kLongestInterval_s) newest_.clear();
  newest_.push_back(value);
  if (newest_.size() > kScatterSamples) newest_.pop_front();
  AddScatter(kept);
}

void SampleChecks::AddForce(const Eigen::Vector3d& force_m_s2, double dt_s) {
  if (dt_s > kLongestInterval_s) return;
  block_force_ += dt_s * force_m_s2;
  block_s_ += dt_s;
  if (block_s_ < kForceBlock_s) return;
  ++n_blocks_;
  force_m_s2_ +=
      (block_force_.norm() / block_s_ - force_m_s2_) / std::min(static_cast<double>(n_blocks_), kForceBlocks);
  block_force_.setZero();
  block_s_ = 0.0;
}

void SampleChecks::CountInterval(double dt_s) {
  if (dt_s > kLongestInterval_s && dt_s > 3.0 / std::max(Rate_hz(), 1e-9)) {
    ++n_gaps_;
    longest_gap_s_ = std::max(longest_gap_s_, dt_s);
  }
  intervals_s_.push_back(dt_s);
  if (intervals_s_.size() > kIntervals) intervals_s_.pop_front();
}

double SampleChecks::Rate_hz() const {
  if (intervals_s_.size() < kFewestIntervals) return 0.0;
  std::vector<double> sorted(intervals_s_.begin(), intervals_s_.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return 1.0 / *middle;
}

void SampleChecks::CountRuns(const Value& sample, double dt_s) {
  for (int i = 0; i < kChannels; ++i) {
    const double value = sample.values[i];
    const bool repeats = value == newest_.back().values[i];
    run_[i] = repeats ? std::min(run_[i] + 1, 1 << 20) : 0;
    run_s_[i] = repeats ? run_s_[i] + dt_s : 0.0;
    if (value > most_[i]) {
      n_most_[i] = 0;
      most_weight_[i] = 0.0;
    }
    if (value < least_[i]) {
      n_least_[i] = 0;
      least_weight_[i] = 0.0;
    }
    most_[i] = std::max(most_[i], value);
    least_[i] = std::min(least_[i], value);
    if (run_[i] + 1 < kSaturatedRun) continue;
    if (value == most_[i]) {
      ++n_most_[i];
      ++most_weight_[i];
    }
    if (value == least_[i]) {
      ++n_least_[i];
      ++least_weight_[i];
    }
  }
}

/// Signals that are smooth over five samples cancel.
void SampleChecks::AddScatter(double kept) {
  if (newest_.size() < kScatterSamples) return;
  const double first_s = 1e-9 * static_cast<double>(newest_[1].t_ns - newest_[0].t_ns);
  for (size_t i = 2; i < kScatterSamples; ++i) {
    const double dt_s = 1e-9 * static_cast<double>(newest_[i].t_ns - newest_[i - 1].t_ns);
    if (std::abs(dt_s - first_s) > 0.3 * first_s) return;
  }
  const Channels difference = newest_[0].values - 4.0 * newest_[1].values + 6.0 * newest_[2].values -
                              4.0 * newest_[3].values + newest_[4].values;
  scatter2_ = kept * scatter2_ + difference.cwiseAbs2();
  n_scatter_ = kept * n_scatter_ + 1.0;
}

double SampleChecks::NoiseOfSample(int channel) const {
  if (n_scatter_ == 0.0) return 0.0;
  return std::sqrt(scatter2_[channel] / (kScatterVariance * n_scatter_));
}

double SampleChecks::Noise(int first) const {
  const double rate_hz = Rate_hz();
  if (n_scatter_ < kFewestScatters || rate_hz <= 0.0) return 0.0;
  double noise = 0.0;
  for (int i = first; i < first + 3; ++i) noise = std::max(noise, NoiseOfSample(i) / std::sqrt(rate_hz));
  return noise;
}

double SampleChecks::Stuck_s(int first) const {
  const int run = std::min({run_[first], run_[first + 1], run_[first + 2]});
  const double time_s = run_s_.segment<3>(first).minCoeff();
  return run >= kStuckSamples && time_s >= kStuck_s ? time_s : 0.0;
}

/// Visits the ends of ranges that many samples have reached.
template <class Visitor>
void SampleChecks::ForEachSaturation(const Visitor& visit) const {
  if (n_scatter_ < kFewestScatters) return;
  const auto consider = [&](int channel, double bound, int n, double weight) {
    if (n < kFewestSaturated) return;
    const double least =
        std::max(kOutsideNoise * NoiseOfSample(channel), channel < 3 ? kOutside_rad_s : kOutside_m_s2);
    if (std::abs(bound - mean_[channel]) >= least)
      visit(Saturation{channel < 3, channel % 3, bound, n, weight / weight_});
  };
  for (int i = 0; i < kChannels; ++i) {
    consider(i, most_[i], n_most_[i], most_weight_[i]);
    consider(i, least_[i], n_least_[i], least_weight_[i]);
  }
}

SampleChecks::Saturation SampleChecks::MostSaturated() const {
  Saturation most;
  ForEachSaturation([&most](const Saturation& other) {
    if (most.n_samples == 0 || other.share > most.share) most = other;
  });
  return most;
}

int SampleChecks::n_saturated() const {
  int n = 0;
  ForEachSaturation([&n](const Saturation& saturation) { n += saturation.n_samples; });
  return n;
}

}  // namespace plslam
