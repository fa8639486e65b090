// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// Integer image gradients, shared by line detection and description.
///
/// 5x5 Sobel: [1 2 0 -2 -1] across, [1 4 6 4 1] along, edge pixels repeated outside. A sharp step of C grey levels
/// gives a peak of `kStepGain * C`; the largest value is 12240. The parabola through the peak and its two neighbours
/// gives the exact position of a box-sampled step, so no other smoothing is needed.
struct Gradients {
  static constexpr int kStepGain = 48;
  /// CV_16SC1, of the size of the image; dx increases to the right, dy downwards.
  cv::Mat dx;
  cv::Mat dy;
};

/// Computes gradients of a CV_8UC1 image of any size; `out` reuses its memory if the size allows.
void ComputeGradients(const cv::Mat& image, Gradients& out);

}  // namespace plslam
