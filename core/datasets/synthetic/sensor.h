// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace plslam::synthetic {

/// Model of the sensor: vignetting, exposure, noise, eight bits.
class Sensor {
 public:
  /// `noise` is the standard deviation in grey levels. The noise of a pixel is a function of seed, stream and pixel.
  Sensor(int width, int height, double noise, uint64_t seed);

  /// Turns radiance (0..255, row by row) into an 8-bit image. `stream` names the exposure: frame and camera.
  cv::Mat Expose(const std::vector<float>& radiance, double gain, uint64_t stream) const;

 private:
  int width_;
  int height_;
  uint64_t seed_;
  std::vector<float> vignette_;
  /// 4096 values of a normal distribution (sum of twelve uniform ones), with exactly the given mean and sigma.
  std::vector<float> noise_;
};

}  // namespace plslam::synthetic
