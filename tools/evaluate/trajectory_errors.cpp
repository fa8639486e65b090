// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/trajectory_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "core/accuracy/consistency.h"

namespace plslam::evaluate {
namespace {

// Returns the position of each pair along the unit in which the delta is measured.
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

// Below this motion a relative error is dominated by the standstill.
constexpr double kMinMotion_m = 0.01;
constexpr double kDegPerRad = 180.0 / M_PI;

PosePairs SelectKeyframes(const PosePairs& pairs, const std::vector<int64_t>& keyframe_t_ns) {
  PosePairs keyframes;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(keyframes), [&](const PosePair& pair) {
    return std::binary_search(keyframe_t_ns.begin(), keyframe_t_ns.end(), pair.t_ns);
  });
  return keyframes;
}

// The kit takes the angle from the trace of the rotation matrix, clamped.
double RotationAngle(const SE3& T) {
  const double cosine = 0.5 * (T.R().trace() - 1.0);
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

double DegPer100m(double rad_per_m) { return rad_per_m * 180.0 / M_PI * 100.0; }

struct Sums {
  int n = 0;
  double t = 0.0;  // metre per metre
  double r = 0.0;  // radian per metre
};

Sums SumOverStarts(const PosePairs& pairs, const std::vector<double>& path_m, double length_m, int step) {
  Sums sums;
  for (size_t first = 0; first < pairs.size(); first += static_cast<size_t>(step)) {
    const auto last = std::upper_bound(path_m.begin(), path_m.end(), path_m[first] + length_m);
    if (last == path_m.end()) break;
    const PosePair& a = pairs[first];
    const PosePair& b = pairs[static_cast<size_t>(last - path_m.begin())];
    const SE3 error = (a.estimate.Inverse() * b.estimate).Inverse() * (a.truth.Inverse() * b.truth);
    ++sums.n;
    sums.t += error.translation().norm() / length_m;
    sums.r += RotationAngle(error) / length_m;
  }
  return sums;
}

}  // namespace

double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Quaterniond d = a.conjugate() * b;
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

AbsoluteErrors ComputeAbsoluteErrors(const PosePairs& pairs, const Similarity& positions,
                                     const Eigen::Quaterniond& orientations) {
  AbsoluteErrors errors;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d aligned = positions.Apply(pair.estimate).translation();
    errors.translation_m.push_back((aligned - pair.truth.translation()).norm());
    errors.rotation_rad.push_back(AngleBetween(orientations * pair.estimate.rotation(), pair.truth.rotation()));
  }
  return errors;
}

Delta DeltaFromText(std::string_view text) {
  Delta delta;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), delta.value);
  const std::string_view unit(end, static_cast<size_t>(text.data() + text.size() - end));
  const bool known = unit == "f" || unit == "s" || unit == "m";
  if (error != std::errc() || !known || !std::isfinite(delta.value) || delta.value <= 0.0) {
    throw std::runtime_error(
        fmt::format("'{}' is not an interval (5f for frames, 1s for seconds, 2.5m for metres)", text));
  }
  if (unit == "s") delta.unit = Delta::Unit::kSeconds;
  if (unit == "m") delta.unit = Delta::Unit::kMetres;
  if (unit == "f" && delta.value != std::floor(delta.value)) {
    throw std::runtime_error(fmt::format("'{}' is not a whole number of frames", text));
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

KeyframeErrors ComputeKeyframeErrors(const PosePairs& pairs, const std::vector<int64_t>& keyframe_t_ns) {
  const PosePairs keyframes = SelectKeyframes(pairs, keyframe_t_ns);
  std::vector<double> translation_m;
  std::vector<double> rotation_deg;
  std::vector<double> ratio;
  std::vector<double> deg_per_m;
  for (size_t i = 1; i < keyframes.size(); ++i) {
    const SE3 error = MotionError(keyframes[i - 1], keyframes[i]);
    const double distance_m = (keyframes[i].truth.translation() - keyframes[i - 1].truth.translation()).norm();
    translation_m.push_back(error.translation().norm());
    rotation_deg.push_back(kDegPerRad * AngleBetween(Eigen::Quaterniond::Identity(), error.rotation()));
    if (distance_m < kMinMotion_m) continue;
    ratio.push_back(translation_m.back() / distance_m);
    deg_per_m.push_back(rotation_deg.back() / distance_m);
  }
  const Statistics relative = Summarise(ratio);
  KeyframeErrors errors;
  errors.motions = static_cast<int>(translation_m.size());
  errors.rmse_m = Summarise(translation_m).rmse;
  errors.rmse_deg = Summarise(rotation_deg).rmse;
  errors.moving = relative.n;
  errors.relative_rmse = relative.rmse;
  errors.t_rel_percent = 100.0 * relative.mean;
  errors.R_rel_deg_per_100m = 100.0 * Summarise(deg_per_m).mean;
  return errors;
}

KittiErrors ComputeKittiErrors(const PosePairs& pairs, const std::vector<double>& lengths_m, int step) {
  const std::vector<double> path_m = TruePath_m(pairs);
  KittiErrors result;
  Sums all;
  for (const double length_m : lengths_m) {
    const Sums sums = SumOverStarts(pairs, path_m, length_m, step);
    if (sums.n == 0) continue;
    result.lengths.push_back({length_m, sums.n, 100.0 * sums.t / sums.n, DegPer100m(sums.r / sums.n)});
    all.n += sums.n;
    all.t += sums.t;
    all.r += sums.r;
  }
  result.segments = all.n;
  if (all.n == 0) return result;
  result.t_rel_percent = 100.0 * all.t / all.n;
  result.r_rel_deg_per_100m = DegPer100m(all.r / all.n);
  return result;
}

KittiErrors ComputeKittiErrors(const PosePairs& pairs) {
  return ComputeKittiErrors(pairs, {100, 200, 300, 400, 500, 600, 700, 800}, 10);
}

KittiErrors ComputeShortKittiErrors(const PosePairs& pairs) {
  return ComputeKittiErrors(pairs, {10, 20, 30, 40, 50}, 1);
}

}  // namespace plslam::evaluate
