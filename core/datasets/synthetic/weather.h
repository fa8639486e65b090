// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace plslam::synthetic {

/// Disturbances between a camera and the world: bright streaks of falling snow, different in every image, and dirt on
/// the lens, which is fixed in the image and different on each of the two lenses.
class Weather {
 public:
  /// `streaks` and `dirt` are their numbers in an image.
  Weather(int width, int height, int streaks, int dirt, uint64_t seed);

  /// Changes radiance (0..255, row by row, in the pixels of the recorded image); no effect without streaks and dirt.
  void Apply(int frame, int camera, std::vector<float>& radiance) const;

 private:
  /// Share of the light that passes each pixel.
  std::vector<float> LightThroughDirt(int dirt, uint64_t key) const;
  void AddStreak(uint64_t key, std::vector<float>& radiance) const;

  int width_;
  int height_;
  int streaks_;
  uint64_t seed_;
  /// By camera; empty without dirt.
  std::vector<std::vector<float>> light_;
};

}  // namespace plslam::synthetic
