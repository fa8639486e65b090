// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace plslam::robot {

/// An image as described by a message of another program; not checked.
struct ForeignImage {
  int64_t t_ns = 0;
  int64_t width_px = 0, height_px = 0;
  int64_t step_bytes = 0;  ///< from one row to the next; 0: without padding
  /// Encoding of the pixels in ROS ("mono8", "bayer_rggb8"); empty: `bytes` is a JPEG or PNG file.
  std::string encoding;
  /// `format` of a sensor_msgs/CompressedImage ("32FC1; compressedDepth png"); needed for depths only.
  std::string format;
  bool is_big_endian = false;
  std::vector<uint8_t> bytes;
};

/// Returns the ROS name of a `bot_core.image_t.pixelformat` (a number of Video4Linux: four characters), empty for JPEG.
/// Throws DatasetError for other formats.
std::string EncodingOfPixelFormat(int32_t pixelformat);

/// Returns its pixels in grey; `white` is the white level of 16 bits. Throws DatasetError if they are not of the size
/// `expected`, or incomplete; the size is checked before decoding.
cv::Mat GreyOf(const ForeignImage& image, const cv::Size& expected, int white);

/// Returns its depths, 16 bits in units of `units_per_m` (core/datasets/recordings/depth_images.h). Throws DatasetError
/// if it is no depth map of the size `expected`.
cv::Mat DepthsOf(const ForeignImage& image, const cv::Size& expected, double units_per_m);

/// Returns the bright value of 16-bit pixels (core/io/images/image_file.h), at least 1; 0 for others. Throws like
/// `GreyOf`.
int BrightWideValue(const ForeignImage& image, const cv::Size& expected);

}  // namespace plslam::robot
