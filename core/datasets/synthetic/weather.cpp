// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/weather.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/datasets/synthetic/exact_math.h"

namespace plslam::synthetic {
namespace {

constexpr uint64_t kStreakKey = 0x5f0ca11ULL;
constexpr uint64_t kDirtKey = 0xd1e7ULL;

// Blobs that touch make a drop look like one.
constexpr int kBlobsOfDirt = 4;

/// Pixels [first, last) of an axis within `reach` of a position.
struct Range {
  int first = 0;
  int last = 0;
};

Range Around(double place, double reach, int size) {
  return {std::clamp(static_cast<int>(std::floor(place - reach)), 0, size),
          std::clamp(static_cast<int>(std::floor(place + reach)) + 1, 0, size)};
}

}  // namespace

Weather::Weather(int width, int height, int streaks, int dirt, uint64_t seed)
    : width_(width), height_(height), streaks_(streaks), seed_(seed) {
  if (dirt == 0) return;
  for (const uint64_t camera : {0, 1}) light_.push_back(LightThroughDirt(dirt, Hash(seed, kDirtKey, camera)));
}

std::vector<float> Weather::LightThroughDirt(int dirt, uint64_t key) const {
  std::vector<float> light(static_cast<size_t>(width_) * height_, 1.0F);
  Random random(key);
  for (int i = 0; i < dirt; ++i) {
    const double u = random.Uniform(0.0, width_);
    const double v = random.Uniform(0.0, height_);
    const double size = random.Uniform(0.008, 0.03) * width_;
    const double opacity = random.Uniform(0.3, 0.9);
    for (int blob = 0; blob < kBlobsOfDirt; ++blob) {
      const double radius = random.Uniform(0.3, 1.0) * size;
      const double blob_u = u + random.Uniform(-1.0, 1.0) * size;
      const double blob_v = v + random.Uniform(-1.0, 1.0) * size;
      // Out of focus: the edge is a third of the blob.
      const Range rows = Around(blob_v, 1.3 * radius, height_);
      const Range columns = Around(blob_u, 1.3 * radius, width_);
      for (int y = rows.first; y < rows.last; ++y) {
        for (int x = columns.first; x < columns.last; ++x) {
          const double distance = std::sqrt((x - blob_u) * (x - blob_u) + (y - blob_v) * (y - blob_v));
          const double inside = Smoothstep((1.3 - distance / radius) / 0.6);
          float& here = light[static_cast<size_t>(y) * width_ + x];
          here = std::min(here, static_cast<float>(1.0 - opacity * inside));
        }
      }
    }
  }
  return light;
}

void Weather::AddStreak(uint64_t key, std::vector<float>& radiance) const {
  Random random(key);
  const double u = random.Uniform(0.0, width_);
  const double v = random.Uniform(0.0, height_);
  const double half_length = random.Uniform(2.0, 14.0);
  const double half_width = random.Uniform(0.5, 1.5);
  const double tilt = random.Uniform(-0.5, 0.5);
  const double opacity = random.Uniform(0.5, 1.0);
  const double sine = Sin(tilt);
  const double cosine = Cos(tilt);
  const double reach = half_length + half_width + 1.0;
  const Range rows = Around(v, reach, height_);
  const Range columns = Around(u, reach, width_);
  for (int y = rows.first; y < rows.last; ++y) {
    for (int x = columns.first; x < columns.last; ++x) {
      const double along = (y - v) * cosine + (x - u) * sine;
      const double across = (x - u) * cosine - (y - v) * sine;
      const double beyond = std::max(std::abs(along) - half_length, 0.0);
      const double distance = std::sqrt(across * across + beyond * beyond);
      const auto cover = static_cast<float>(opacity * std::clamp(half_width + 0.5 - distance, 0.0, 1.0));
      float& here = radiance[static_cast<size_t>(y) * width_ + x];
      here += cover * (255.0F - here);
    }
  }
}

void Weather::Apply(int frame, int camera, std::vector<float>& radiance) const {
  const uint64_t key = Hash(seed_, kStreakKey, static_cast<uint64_t>(frame) * 2 + static_cast<uint64_t>(camera));
  for (int i = 0; i < streaks_; ++i) AddStreak(Hash(key, static_cast<uint64_t>(i)), radiance);
  if (light_.empty()) return;
  const std::vector<float>& light = light_[static_cast<size_t>(camera)];
  std::transform(radiance.begin(), radiance.end(), light.begin(), radiance.begin(), std::multiplies<>());
}

}  // namespace plslam::synthetic
