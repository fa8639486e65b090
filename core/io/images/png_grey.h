// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// Takes the filters of a PNG's rows off (ISO/IEC 15948, 9.2), for pixels of one byte. `filtered` has, row after row,
/// the number of the filter and then a byte for each column of `out` (CV_8UC1), which it fills. False where a number
/// is none of the five filters; `out` is then of no use.
bool TakeFiltersOff(const uint8_t* filtered, cv::Mat& out);

/// The pixels of a PNG file that datasets are made of, three times as fast as by libpng: 8 bits of grey, not
/// interlaced, nothing transparent. nullopt for every other file, and for one in which anything at all is out of
/// order: what libpng makes of that is decided there alone.
std::optional<cv::Mat> DecodeGreyPng(std::span<const uint8_t> file, cv::Size size);

}  // namespace plslam
