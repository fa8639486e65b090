// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/map/occupancy_grid.h"
#include "core/map/surface_cloud.h"
#include "viewer_headless/report/report_data.h"

namespace plslam::viewer {

/// Limits of the surfaces in a page: about 1.4 MB of points.
struct SurfaceLimits {
  size_t points = 100'000;
  int grid_px = 4096;  ///< longest side of the picture of the grid
};

/// A cloud with at most `most` points: the mean of those in cubes that are as large as necessary. Opposite sides of a thin
/// wall stay apart.
struct ThinnedCloud {
  double spacing_m = 0.0;
  std::vector<SurfacePoint> points;
};
ThinnedCloud Thin(std::vector<SurfacePoint> points, double spacing_m, size_t most);

/// Returns the surfaces for the page.
ReportSurfaces SurfaceTables(const SurfaceCloud& cloud, const OccupancyGrid& grid, const SurfaceLimits& limits);

}  // namespace plslam::viewer
