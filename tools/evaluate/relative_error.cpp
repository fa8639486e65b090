// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/relative_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "tools/evaluate/absolute_error.h"

namespace plslam {
namespace {

// Where each pair stands on the scale that the delta is measured on.
std::vector<double> Positions(const PosePairs& pairs, Delta::Unit unit) {
  if (unit == Delta::Unit::kMetres) return TruePath_m(pairs);
  std::vector<double> positions(pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    const bool frames = unit == Delta::Unit::kFrames;
    positions[i] = frames ? static_cast<double>(i) : 1e-9 * static_cast<double>(pairs[i].t_ns - pairs[0].t_ns);
  }
  return positions;
}

// The element after `begin` nearest to `target` in increasing values; `begin` must not be the end.
size_t NearestIndex(const std::vector<double>& values, size_t begin, double target) {
  const auto first = values.begin() + static_cast<std::ptrdiff_t>(begin);
  auto found = std::lower_bound(first, values.end(), target);
  if (found == values.end() || (found != first && target - *(found - 1) < *found - target)) --found;
  return static_cast<size_t>(found - values.begin());
}

}  // namespace

Delta DeltaFromText(std::string_view text) {
  Delta delta;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), delta.value);
  const std::string_view unit(end, static_cast<size_t>(text.data() + text.size() - end));
  const bool known = unit == "f" || unit == "s" || unit == "m";
  if (error != std::errc() || !known || !std::isfinite(delta.value) || delta.value <= 0.0) {
    throw std::runtime_error(
        fmt::format("'{}' is no interval (5f for frames, 1s for seconds, 2.5m for metres)", text));
  }
  if (unit == "s") delta.unit = Delta::Unit::kSeconds;
  if (unit == "m") delta.unit = Delta::Unit::kMetres;
  if (unit == "f" && delta.value != std::floor(delta.value)) {
    throw std::runtime_error(fmt::format("'{}' is no whole number of frames", text));
  }
  return delta;
}

std::string DeltaText(const Delta& delta) {
  const char* unit = delta.unit == Delta::Unit::kFrames ? "f" : (delta.unit == Delta::Unit::kSeconds ? "s" : "m");
  return fmt::format("{:g}{}", delta.value, unit);
}

std::vector<double> TruePath_m(const PosePairs& pairs) {
  std::vector<double> path(pairs.size(), 0.0);
  for (size_t i = 1; i < pairs.size(); ++i) {
    path[i] = path[i - 1] + (pairs[i].truth.translation() - pairs[i - 1].truth.translation()).norm();
  }
  return path;
}

RelativeErrors ComputeRelativeErrors(const PosePairs& pairs, const Delta& delta) {
  RelativeErrors errors;
  const std::vector<double> positions = Positions(pairs, delta.unit);
  for (size_t i = 0; i + 1 < pairs.size(); ++i) {
    // At the end of the sequence the nearest pair would be nearer and nearer.
    if (positions[i] + (1.0 - 1e-6) * delta.value > positions.back()) break;
    const size_t j = NearestIndex(positions, i + 1, positions[i] + delta.value);
    if (std::abs(positions[j] - positions[i] - delta.value) > 0.5 * delta.value) continue;
    if (delta.unit == Delta::Unit::kFrames && positions[j] - positions[i] != delta.value) continue;
    const SE3 error = MotionError(pairs[i], pairs[j]);
    errors.translation_m.push_back(error.translation().norm());
    errors.rotation_rad.push_back(AngleBetween(Eigen::Quaterniond::Identity(), error.rotation()));
  }
  return errors;
}

}  // namespace plslam
