// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "tools/evaluate/drawing/drawing.h"

namespace plslam::evaluate {

/// Returns a figure of run times from a run's summary.json: stages of odometry (a frame), of mapping and of loop
/// closing (a keyframe), each with a dot at the median and a line to the 95 % quantile, on a logarithmic axis; and the
/// CPU time of each process (a frame). Values that are missing in the summary are left out.
Drawing RuntimeFigure(const std::string& title, const nlohmann::json& summary);

}  // namespace plslam::evaluate
