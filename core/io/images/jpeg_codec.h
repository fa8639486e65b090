// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

namespace plslam {

/// The pixels of a JPEG file (ITU-T T.81) by libjpeg as 8-bit grey: the luma that the file has, without the detour
/// over colour; of files in RGB or CMYK the same weights (ITU-R BT.601). The orientation that cameras note is not
/// looked at. `size` is what the header says; the caller has found it bearable. Throws std::runtime_error with
/// libjpeg's reason where the file cannot be decoded, ends early or is of another size; what is damaged in between
/// goes unseen, as the format has no check sums.
cv::Mat DecodeJpeg(std::span<const uint8_t> bytes, cv::Size size);

/// An 8-bit grey image as a JPEG file. `quality` from 0 to 100 (best), as libjpeg counts. Throws
/// std::invalid_argument for other images, and those of more than 65,500 pixels a side.
std::string EncodeJpeg(const cv::Mat& grey, int quality);

}  // namespace plslam
