// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "core/datasets/synthetic/rasterizer.h"

namespace plslam::synthetic {

/// The grey values (0..255, before any effect of a camera) of a view, row by row.
///
/// Pixels inside one surface are shaded once at their centre with filtered textures; pixels crossed by a border are
/// split by 32 samples, no two in one row or column of the pixel, so that borders sit right to some hundredths of a
/// pixel.
std::vector<float> RenderRadiance(const Scene& scene, const View& view);

/// The same of a camera that moves while the rows of its image are read one after the other: `view_at` is the view at
/// a share of the time that this takes, 0 at the first row. Bands of a few rows are rendered as of one time. Bodies
/// do not move meanwhile.
std::vector<float> RenderRollingShutter(const Scene& scene, const std::function<View(double)>& view_at);

/// Depth (z, metres) at the pixel centres; 0 for the sky. Exact but for the rounding to float.
std::vector<float> RenderDepthMap(const Scene& scene, const View& view);

/// The quad of the scene at the pixel centres; -1 for the sky.
std::vector<int> RenderQuadMap(const Scene& scene, const View& view);

}  // namespace plslam::synthetic
