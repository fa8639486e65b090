#pragma once

#include <vector>

#include "core/datasets/synthetic/rasterizer.h"

namespace plslam::synthetic {

/// The grey values (0..255, before any effect of a camera) of a view, row by row.
///
/// Pixels inside one surface are shaded once at their centre with filtered textures; pixels crossed by a border are split
/// by 32 samples, no two in one row or column of the pixel, so that borders sit right to some hundredths of a pixel.
std::vector<float> RenderRadiance(const Scene& scene, const View& view);

/// Depth (z, metres) at the pixel centres; 0 for the sky. Exact but for the rounding to float.
std::vector<float> RenderDepthMap(const Scene& scene, const View& view);

/// The quad of the scene at the pixel centres; -1 for the sky.
std::vector<int> RenderQuadMap(const Scene& scene, const View& view);

}  // namespace plslam::synthetic
