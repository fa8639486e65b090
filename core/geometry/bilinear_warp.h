// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// A fixed warp of 8-bit images, bilinear at 1/32 pixel: identical to cv::remap with INTER_LINEAR, in less than half
/// the time, because addresses and weights are precomputed and the sums fit 16 bits.
class BilinearWarp {
 public:
  static constexpr int kSubpixels = 32;

  /// Images of size `source` become images of size `result`, whose pixels are 0 until `SetSource`. Throws
  /// std::runtime_error for images smaller than 2 x 2.
  BilinearWarp(cv::Size source, cv::Size result);
  /// The same for images of one size before and after.
  BilinearWarp(int width_px, int height_px) : BilinearWarp({width_px, height_px}, {width_px, height_px}) {}

  /// Sets the source (x, y) of pixel (u, v) of the result, in 1/32 pixels within [0, 32 (source size - 1)].
  void SetSource(int u, int v, int x, int y);

  /// Returns a new image. `image` is CV_8UC1 of size `source`.
  cv::Mat Apply(const cv::Mat& image) const;

 private:
  struct Weights {
    uint8_t x;
    uint8_t y;
  };

  void WarpRow(const uint8_t* image, int v, uint8_t* out) const;

  cv::Size source_;
  cv::Size result_;
  // Offset of the upper left of the four pixels in the image, and weights of the right and lower ones in 32nds.
  std::vector<int32_t> offsets_;
  std::vector<Weights> weights_;
  // 255 for pixels with a source.
  std::vector<uint8_t> mask_;
};

}  // namespace plslam
