// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

#include "core/files/dataset_error.h"

namespace plslam {

/// Layout of the pixels of a sensor_msgs/Image; not checked.
struct RosPixels {
  int64_t width_px = 0, height_px = 0;
  int64_t step_bytes = 0;  ///< from one row to the next; 0: without padding
  std::string encoding;    ///< a name of sensor_msgs/image_encodings: "mono8", "bayer_rggb8"
  bool is_big_endian = false;
  std::span<const uint8_t> data;
};

/// Returns the reason why images of this encoding cannot be read; empty if they can.
std::string PixelEncodingComplaint(const std::string& encoding);

/// Returns grey pixels: the luma of YUV, Bayer patterns by OpenCV's demosaicing, all others as in `GreyPixels`. `white`
/// is the white level of 16 bits, and `clipped`, if given, becomes the part of the pixels above. Throws DatasetError if
/// the encoding is unknown, the image is not of the size `expected`, or bytes are missing.
cv::Mat GreyOfRosPixels(const RosPixels& image, const cv::Size& expected, int white, double* clipped = nullptr);

/// Returns the pixels without padding, in the byte order of this machine; `type` is OpenCV's. Throws DatasetError if
/// bytes are missing.
cv::Mat PixelsAsTheyAre(const RosPixels& image, const cv::Size& size, int type);

/// Returns the bright value of 16-bit pixels (image_file.h), at least 1; 0 for others. Throws like `GreyOfRosPixels`.
int BrightWideValue(const RosPixels& image, const cv::Size& expected);

}  // namespace plslam
