#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "tools/rectify_check/row_errors.h"

namespace plslam {

/// The rectified pair side by side, with epipolar lines (each pixel row should meet the same thing on both sides) and matched
/// points: green where rows agree to a pixel, orange to two, red beyond. `caption` stands below.
cv::Mat DrawRectification(const cv::Mat& left, const cv::Mat& right, const std::vector<RowMatch>& matches,
                          const std::string& caption);

}  // namespace plslam
