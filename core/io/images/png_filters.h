// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace plslam {

/// Takes the filters of a PNG's rows off (ISO/IEC 15948, 9.2), for pixels of one byte. `filtered` has, row after row,
/// the number of the filter and then a byte for each column of `out` (CV_8UC1), which it fills. False where a number
/// is none of the five filters; `out` is then of no use.
bool TakeFiltersOff(const uint8_t* filtered, cv::Mat& out);

}  // namespace plslam
