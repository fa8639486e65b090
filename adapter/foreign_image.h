// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace plslam::adapter {

/// An image as a message of another program describes it; nothing of it has been checked.
struct ForeignImage {
  int64_t t_ns = 0;
  int64_t width_px = 0, height_px = 0;
  int64_t step_bytes = 0;  ///< from one row to the next; 0: without padding
  /// Of pixels, as ROS names it ("mono8", "bayer_rggb8"); empty: `bytes` is a JPEG or PNG file.
  std::string encoding;
  bool is_big_endian = false;
  std::vector<uint8_t> bytes;
};

/// The name that ROS has for a `bot_core.image_t.pixelformat` (a number of Video4Linux: four characters), empty for
/// JPEG. Throws DatasetError for other formats.
std::string EncodingOfPixelFormat(int32_t pixelformat);

/// Its pixels in grey; `white` is the white level of 16 bits. Throws DatasetError where they are not of the size
/// `expected`, or not all there; nothing is decoded before the size is known.
cv::Mat GreyOf(const ForeignImage& image, const cv::Size& expected, int white);

/// The largest value of pixels of 16 bits, at least 1; 0 for others. Throws like `GreyOf`.
int LargestWideValue(const ForeignImage& image, const cv::Size& expected);

}  // namespace plslam::adapter
