// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_camera.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace plslam {
namespace {

constexpr std::array<const char*, 6> kNames{"f_px", "cx_px", "cy_px", "baseline_m", "width_px", "height_px"};
constexpr double kLargestSize_px = 1e6;
constexpr double kSame_px = 1e-4;
constexpr double kLargeDisparity_px = 100.0;

using Numbers = std::array<double, kNames.size()>;

Numbers NumbersOf(const StereoCamera& camera) {
  return {camera.f_px,
          camera.cx_px,
          camera.cy_px,
          camera.baseline_m,
          static_cast<double>(camera.width_px),
          static_cast<double>(camera.height_px)};
}

Numbers NumbersOf(const StoredMap& stored, const std::string& path) {
  Numbers numbers{};
  if (stored.rig.size() != sizeof(numbers)) {
    throw std::runtime_error(fmt::format("{}: does not contain the camera with which it was made", path));
  }
  std::memcpy(numbers.data(), stored.rig.data(), sizeof(numbers));
  return numbers;
}

bool IsSize(double value) { return value >= 1.0 && value <= kLargestSize_px && value == std::floor(value); }

}  // namespace

std::vector<uint8_t> CameraBytes(const StereoCamera& camera) {
  const Numbers numbers = NumbersOf(camera);
  std::vector<uint8_t> bytes(sizeof(numbers));
  std::memcpy(bytes.data(), numbers.data(), sizeof(numbers));
  return bytes;
}

StereoCamera MapCamera(const StoredMap& stored, const std::string& path) {
  const Numbers numbers = NumbersOf(stored, path);
  for (const double number : numbers) {
    if (!std::isfinite(number)) throw std::runtime_error(fmt::format("{}: its camera has a number {}", path, number));
  }
  if (!(numbers[0] > 0.0) || !(numbers[3] > 0.0) || !IsSize(numbers[4]) || !IsSize(numbers[5])) {
    throw std::runtime_error(
        fmt::format("{}: its camera is invalid: a focal length of {} px, a baseline of {} m and images of {} x {} px",
                    path, numbers[0], numbers[3], numbers[4], numbers[5]));
  }
  return {numbers[0], numbers[1], numbers[2], numbers[3], static_cast<int>(numbers[4]), static_cast<int>(numbers[5])};
}

std::string CameraDifference(const StereoCamera& was, const StereoCamera& is) {
  const Numbers a = NumbersOf(was), b = NumbersOf(is);
  // The error of a disparity of 100 px is that of f b, of which the focal length has been judged by itself.
  const double baseline_tolerance_m = std::abs(was.baseline_m) * kSame_px / kLargeDisparity_px;
  const Numbers tolerances{kSame_px, kSame_px, kSame_px, baseline_tolerance_m, 0.0, 0.0};
  std::string text;
  for (size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) <= tolerances[i]) continue;
    // With all their digits: two numbers that differ must not look the same.
    text += fmt::format("{}{} {} instead of {}", text.empty() ? "" : ", ", kNames[i], b[i], a[i]);
  }
  return text;
}

}  // namespace plslam
