// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// Removes the filters of a PNG's rows (ISO/IEC 15948, 9.2), for pixels of one byte. `filtered` has, row after row, the
/// number of the filter and then a byte for each column of `out` (CV_8UC1), which it fills. Returns false if a number
/// is none of the five filters; `out` is then invalid.
bool TakeFiltersOff(const uint8_t* filtered, cv::Mat& out);

/// Decodes the type of PNG file that datasets consist of, three times as fast as libpng: 8 bits of grey, not
/// interlaced, without transparency. Returns nullopt for all others and for any defect: libpng decides about those.
std::optional<cv::Mat> DecodeGreyPng(std::span<const uint8_t> file, cv::Size size);

}  // namespace plslam
