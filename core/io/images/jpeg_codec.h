// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

namespace plslam {

/// Decodes a JPEG file (ITU-T T.81) by libjpeg as 8-bit grey: the luma of the file, without conversion to colour; the
/// same weights (ITU-R BT.601) for files in RGB or CMYK. The orientation tag of cameras is ignored. `size` is the size
/// in the header, which the caller has checked. Throws std::runtime_error with libjpeg's reason if the file cannot be
/// decoded, ends early or has another size; damage in between is not detected, as the format has no checksums.
cv::Mat DecodeJpeg(std::span<const uint8_t> bytes, cv::Size size);

/// Encodes an 8-bit grey image as a JPEG file. `quality` from 0 to 100 (best), as libjpeg counts. Throws
/// std::invalid_argument for other images, and those of more than 65,500 pixels a side.
std::string EncodeJpeg(const cv::Mat& grey, int quality);

}  // namespace plslam
