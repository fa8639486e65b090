// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate/compare/comparison.h"
#include "tools/evaluate/drawing/drawing.h"

namespace plslam {

struct NamedDrawing {
  std::string name;
  Drawing drawing;
};

/// Of groups of one dataset: the typical trajectory of the first from above with the truth, and those of the others'
/// runs of the same (the same seed of a built-in world, whose ways differ); dots for the errors, the time of
/// odometry, CPU and memory. What no run tells is left out. Reads the trajectories of the runs; those that are
/// missing or cannot be read are left out too.
std::vector<NamedDrawing> ComparisonFigures(const std::vector<const RunGroup*>& groups);

}  // namespace plslam
