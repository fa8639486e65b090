// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "tools/evaluate/accuracy.h"

namespace plslam {

/// A picture of both paths from above (the two axes in which the true path extends most, equal scale) and of the
/// position and orientation errors over time; 8-bit BGR. Without pairs it says so.
cv::Mat PlotAccuracy(const Accuracy& accuracy, const std::string& title);

}  // namespace plslam
