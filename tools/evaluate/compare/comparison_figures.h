// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate/compare/comparison.h"
#include "tools/evaluate/drawing/drawing.h"

namespace plslam::evaluate {

/// A row of dots with a name, one for each run.
struct DotRow {
  std::string name;
  std::vector<double> values;
  double median = 0.0;
  Ink ink{};
};

/// Values of several groups of runs over one axis from 0, at column width: a dot each, a bar at the median.
Drawing DotFigure(const std::string& title, const std::string& axis, const std::vector<DotRow>& rows);

/// Returns colours in turn that people with any colour vision can distinguish (Okabe and Ito 2008).
Ink InkOf(size_t i);

struct NamedDrawing {
  std::string name;
  Drawing drawing;
};

/// Returns the figures of the groups of one dataset: a top view of the first group's typical trajectory with the truth,
/// and of the other groups' runs of the same data (the same seed of a built-in world, since paths differ between
/// seeds); dots for the errors, the time of odometry, CPU and memory. Measures that no run has are left out. Reads the
/// trajectories of the runs; missing or unreadable ones are left out too.
std::vector<NamedDrawing> ComparisonFigures(const std::vector<const RunGroup*>& groups);

}  // namespace plslam::evaluate
