// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "tools/rectify_check/row_errors.h"

namespace plslam::rectify_check {

/// An 8-bit grey image, and its mask (`Rectifier::left_mask`).
struct MaskedImage {
  cv::Mat pixels;
  cv::Mat mask;
};

/// The rectified pair side by side, with epipolar lines (each pixel row should meet the same thing on both sides) and
/// matched points: green where rows agree to a pixel, orange to two, red beyond. Shaded where a mask is 0; masks may be
/// empty. `caption` is below.
cv::Mat DrawRectification(const MaskedImage& left, const MaskedImage& right, const std::vector<RowMatch>& matches,
                          const std::string& caption);

}  // namespace plslam::rectify_check
