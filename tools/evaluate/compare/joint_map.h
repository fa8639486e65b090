// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate/run_record.h"

namespace plslam::evaluate {

/// Returns the report of the first run, with paths and landmarks of the others in its map, each in a different colour.
/// The others are those of the same dataset, up to 6. Throws std::runtime_error if there is no other, or one of them
/// has no report.html. `comparison_link` is the address of the page that compares the runs, which is linked; empty:
/// none.
std::string JointMapPage(const std::vector<RunRecord>& runs, const std::string& comparison_link = "");

}  // namespace plslam::evaluate
