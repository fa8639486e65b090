// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// One stereo pair as recorded, not rectified. `right` is 8-bit like `left`, or a 16-bit depth map for RGB-D rigs.
struct StereoImages {
  int64_t frame_id = 0;
  int64_t t_ns = 0;
  cv::Mat left;
  cv::Mat right;
};

}  // namespace plslam
