// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/map/map.h"
#include "viewer_headless/report/report_data.h"

namespace plslam {

/// What a page can show of a map at most.
struct MapLimits {
  size_t points = 150'000;
  size_t segments = 30'000;
  size_t edges = 40'000;
  size_t observer_bytes = 1'500'000;  ///< beyond, nothing is said of who observes which landmark
};

/// The map for the page. Where it has more than the limits allow, the landmarks that fewest keyframes see are left
/// out, and the covisibility edges with fewest shared landmarks, or who observes the landmarks; `notes` then says so.
ReportMap MapTables(const Map& map, const MapLimits& limits, std::vector<std::string>* notes);

}  // namespace plslam
