#pragma once

#include <functional>
#include <vector>

#include "core/datasets/synthetic/renderer.h"

namespace plslam::synthetic {

/// As `RenderRadiance`, of a camera that moves while the rows of its image are read one after the other: `view_at` is the view at a
/// share of the time that this takes, 0 at the first row. Bands of a few rows are rendered as of one time. Bodies do
/// not move meanwhile.
std::vector<float> RenderRollingShutter(const Scene& scene, const std::function<View(double)>& view_at);

}  // namespace plslam::synthetic
