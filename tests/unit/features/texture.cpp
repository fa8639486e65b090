// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/features/texture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace plslam::test {
namespace {

struct Wave {
  double fx, fy, phase, amplitude;
};

std::vector<Wave> MakeWaves(uint64_t seed, double softness) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Wave> waves(60);
  for (Wave& w : waves) {
    const double direction = 2.0 * std::numbers::pi * uniform(random);
    const double length_px = softness * 5.0 * std::pow(8.0, uniform(random));
    const double frequency = 2.0 * std::numbers::pi / length_px;
    w = {frequency * std::cos(direction), frequency * std::sin(direction), 2.0 * std::numbers::pi * uniform(random),
         9.0};
  }
  return waves;
}

}  // namespace

cv::Mat RenderTexture(int width_px, int height_px, const View& view, uint64_t seed, double softness) {
  return RenderTexture(width_px, height_px, view, seed, softness, [](double x, double) { return x; });
}

cv::Mat RenderTexture(int width_px, int height_px, const View& view, uint64_t seed, double softness,
                      const std::function<double(double, double)>& column) {
  const std::vector<Wave> waves = MakeWaves(seed, softness);
  std::mt19937_64 random(view.noise_seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  cv::Mat image(height_px, width_px, CV_8UC1);
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      double value = 100.0;
      const double shown = column(x, y) + view.shift_x_px;
      for (const Wave& w : waves) {
        value += w.amplitude * std::sin(w.fx * shown + w.fy * (y + view.shift_y_px) + w.phase);
      }
      value = view.gain * value + view.offset + view.noise * normal(random);
      image.at<uint8_t>(y, x) = static_cast<uint8_t>(std::clamp(std::lround(value), 0L, 255L));
    }
  }
  return image;
}

cv::Mat RandomImage(int width_px, int height_px, uint64_t seed) {
  std::mt19937_64 random(seed);
  cv::Mat image(height_px, width_px, CV_8UC1);
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) image.at<uint8_t>(y, x) = static_cast<uint8_t>(random() & 255U);
  }
  return image;
}

}  // namespace plslam::test
