// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/sensor.h"

#include <algorithm>
#include <cmath>

#include "core/datasets/synthetic/exact_math.h"

namespace plslam::synthetic {
namespace {

constexpr int kNoiseBits = 12;
constexpr double kVignette = 0.08;  // share of the light lost in the corners

std::vector<float> NoiseTable(double deviation) {
  constexpr int kSize = 1 << kNoiseBits;
  Random random(20231);
  std::vector<double> values(kSize);
  double mean = 0.0;
  for (double& value : values) {
    for (int i = 0; i < 12; ++i) {
      value += random.Uniform();
    }
    mean += value / kSize;
  }
  double variance = 0.0;
  for (const double value : values) {
    variance += (value - mean) * (value - mean) / kSize;
  }
  const double scale = deviation / std::sqrt(variance);
  std::vector<float> table(kSize);
  std::transform(values.begin(), values.end(), table.begin(),
                 [mean, scale](double value) { return static_cast<float>((value - mean) * scale); });
  return table;
}

}  // namespace

Sensor::Sensor(int width, int height, double noise, uint64_t seed)
    : width_(width),
      height_(height),
      seed_(seed),
      vignette_(static_cast<size_t>(width) * height),
      noise_(NoiseTable(noise)) {
  const double cx = 0.5 * (width - 1);
  const double cy = 0.5 * (height - 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double r2 = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (cx * cx + cy * cy);
      vignette_[static_cast<size_t>(y) * width + x] = static_cast<float>(1.0 - kVignette * r2);
    }
  }
}

cv::Mat Sensor::Expose(const std::vector<float>& radiance, double gain, uint64_t stream) const {
  cv::Mat image(height_, width_, CV_8UC1);
  const uint64_t key = Hash(seed_, stream);
  const auto gain_f = static_cast<float>(gain);
  constexpr uint64_t kMask = (1U << kNoiseBits) - 1;
  for (int y = 0; y < height_; ++y) {
    uint8_t* row = image.ptr<uint8_t>(y);
    const size_t first = static_cast<size_t>(y) * width_;
    uint64_t bits = 0;
    for (int x = 0; x < width_; ++x) {
      if (x % 4 == 0) {
        bits = Mix(key + 0x9e3779b97f4a7c15ULL * (first + x + 1));
      }
      const float noise = noise_[bits & kMask];
      bits >>= 16;
      const float value = radiance[first + x] * vignette_[first + x] * gain_f + noise + 0.5F;
      row[x] = static_cast<uint8_t>(std::clamp(value, 0.0F, 255.0F));
    }
  }
  return image;
}

}  // namespace plslam::synthetic
