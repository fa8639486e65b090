// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

#include "core/datasets/recordings/pixel_encodings.h"

namespace plslam {

/// Units of 16-bit depths in ROS (REP 118): millimetres.
inline constexpr double kRosDepthUnits_per_m = 1000.0;

/// Returns the reason why images of this encoding are no depths; empty if they are (16UC1, mono16 or 32FC1).
std::string DepthEncodingComplaint(const std::string& encoding);

// Depth maps of ROS as 16-bit images. 16-bit depths stay as they are; depths in metres (32 bits) become `units_per_m`.
// 0: no depth; also from NaN, negative and infinite values, and beyond the range of 16 bits (65 m in millimetres).

/// Returns the depths of a sensor_msgs/Image. Throws DatasetError for other encodings, if it is not of the size
/// `expected`, or bytes are missing.
cv::Mat DepthsOfRosPixels(const RosPixels& image, const cv::Size& expected, double units_per_m);

/// Returns the depths of a sensor_msgs/CompressedImage: a PNG file of 16 bits, or compressed_depth_image_transport's
/// PNG files of depths and of inverse depths. `format` is that of the message ("32FC1; compressedDepth png"). Throws
/// DatasetError for other formats (RVL), damaged files, and other sizes.
cv::Mat DepthsOfCompressed(const std::string& format, std::span<const uint8_t> bytes, const cv::Size& expected,
                           double units_per_m);

}  // namespace plslam
