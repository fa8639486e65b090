#pragma once

#include <vector>

#include "core/datasets/synthetic/rasterizer.h"
#include "core/datasets/synthetic/world.h"

namespace plslam::synthetic {

/// The grey values (0..255, before any effect of a camera) of a view, row by row.
///
/// Pixels inside one surface are shaded once at their centre with filtered textures; pixels crossed by a border are split
/// by 32 samples, no two in one row or column of the pixel, so that borders sit right to some hundredths of a pixel.
std::vector<float> RenderRadiance(const World& world, const View& view);

/// Depth (z, metres) at the pixel centres; 0 for the sky. Exact but for the rounding to float.
std::vector<float> RenderDepthMap(const World& world, const View& view);

}  // namespace plslam::synthetic
