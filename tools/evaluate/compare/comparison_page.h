// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate/compare/comparison.h"

namespace plslam::evaluate {

/// Returns a self-contained page for any browser (no scripts, no external files): the table with medians, worst and
/// spread; figures by dataset; each run with its folder and results; and the options of each configuration that differ.
/// `map_link` is the address of the page with the maps of the runs, which is linked; empty: none.
std::string ComparisonPage(const std::vector<RunGroup>& groups, const std::string& map_link = "");

}  // namespace plslam::evaluate
