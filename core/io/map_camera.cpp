#include "core/io/map_camera.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace plslam {
namespace {

// Focal length, principal point, baseline, width, height.
constexpr size_t kNumbers = 6;
constexpr double kLargestSize_px = 1e6;

bool IsSize(double value) { return value >= 1.0 && value <= kLargestSize_px && value == std::floor(value); }

}  // namespace

StereoCamera MapCamera(const StoredMap& stored, const std::string& path) {
  std::array<double, kNumbers> numbers{};
  if (stored.rig.size() != sizeof(numbers)) {
    throw std::runtime_error(fmt::format("{}: says nothing of the camera it was made with", path));
  }
  std::memcpy(numbers.data(), stored.rig.data(), sizeof(numbers));
  for (const double number : numbers) {
    if (!std::isfinite(number)) throw std::runtime_error(fmt::format("{}: its camera has a number {}", path, number));
  }
  if (!(numbers[0] > 0.0) || !IsSize(numbers[4]) || !IsSize(numbers[5])) {
    throw std::runtime_error(fmt::format("{}: no camera has a focal length of {} px and images of {} x {} px", path,
                                         numbers[0], numbers[4], numbers[5]));
  }
  return {numbers[0], numbers[1], numbers[2], numbers[3], static_cast<int>(numbers[4]), static_cast<int>(numbers[5])};
}

}  // namespace plslam
