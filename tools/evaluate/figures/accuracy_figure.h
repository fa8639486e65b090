// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tools/evaluate/accuracy.h"
#include "tools/evaluate/drawing/drawing.h"

namespace plslam::evaluate {

/// Both paths from above (the two axes in which the true path extends most, equal scale), the estimate after the
/// alignment, and the position and orientation errors over time; at column width. Without pairs it shows the reason.
Drawing AccuracyFigure(const std::string& title, const Accuracy& accuracy);

}  // namespace plslam::evaluate
