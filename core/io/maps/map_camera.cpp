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
    throw std::runtime_error(fmt::format("{}: says nothing of the camera it was made with", path));
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
  if (!(numbers[0] > 0.0) || !IsSize(numbers[4]) || !IsSize(numbers[5])) {
    throw std::runtime_error(fmt::format("{}: no camera has a focal length of {} px and images of {} x {} px", path,
                                         numbers[0], numbers[4], numbers[5]));
  }
  return {numbers[0], numbers[1], numbers[2], numbers[3], static_cast<int>(numbers[4]), static_cast<int>(numbers[5])};
}

void CheckCamera(const StoredMap& stored, const StereoCamera& camera, const std::string& path) {
  const Numbers was = NumbersOf(stored, path);
  const Numbers is = NumbersOf(camera);
  for (size_t i = 0; i < is.size(); ++i) {
    if (was[i] == is[i]) continue;
    throw std::runtime_error(fmt::format("{}: the map was made with another camera: {} {} instead of {} (rectified)",
                                         path, kNames[i], was[i], is[i]));
  }
}

}  // namespace plslam
