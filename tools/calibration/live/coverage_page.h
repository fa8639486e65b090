// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/calibration/live/picture_taker.h"

namespace plslam::calibration {

/// Returns a page that shows the positions of the boards in the pictures, missing views, and the pictures (files beside
/// the page). While `is_running` it reloads itself every second.
std::string CoveragePage(const PictureTaker& taker, const std::vector<std::string>& pictures, bool is_running);

}  // namespace plslam::calibration
