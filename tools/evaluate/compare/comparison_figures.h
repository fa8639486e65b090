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

/// Colours that people with any colour vision tell apart, in turn (Okabe and Ito 2008).
Ink InkOf(size_t i);

struct NamedDrawing {
  std::string name;
  Drawing drawing;
};

/// Of groups of one dataset: the typical trajectory of the first from above with the truth, and those of the others'
/// runs of the same (the same seed of a built-in world, whose ways differ); dots for the errors, the time of
/// odometry, CPU and memory. What no run tells is left out. Reads the trajectories of the runs; those that are
/// missing or cannot be read are left out too.
std::vector<NamedDrawing> ComparisonFigures(const std::vector<const RunGroup*>& groups);

}  // namespace plslam::evaluate
