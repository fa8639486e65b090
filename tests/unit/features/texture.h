// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <random>

#include <opencv2/core/mat.hpp>

namespace plslam::test {

/// Difference of a view of the texture from the plain one.
struct View {
  /// The view's pixel (x, y) shows the texture at (x + shift_x, y + shift_y): for a right image, the disparity.
  double shift_x_px = 0.0;
  double shift_y_px = 0.0;
  double gain = 1.0;
  double offset = 0.0;
  double noise = 0.0;
  uint64_t noise_seed = 1;
};

/// A smooth random texture without period (waves of many directions and lengths from 5 pixels up), defined on the
/// plane, so that views with any sub-pixel shift are exact. `softness` lengthens the shortest wave.
cv::Mat RenderTexture(int width_px, int height_px, const View& view, uint64_t seed = 1, double softness = 1.0);

/// The same where pixel (x, y) shows the texture at (`column`(x, y), y): a slanted surface.
cv::Mat RenderTexture(int width_px, int height_px, const View& view, uint64_t seed, double softness,
                      const std::function<double(double, double)>& column);

/// Independent random pixels.
cv::Mat RandomImage(int width_px, int height_px, uint64_t seed);

}  // namespace plslam::test
