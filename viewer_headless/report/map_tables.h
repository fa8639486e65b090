// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/map/map.h"
#include "viewer_headless/report/report_data.h"

namespace plslam::viewer {

/// The row of each keyframe in the tables of a page, by id.
using RowOfKeyframe = std::map<KeyframeId, int32_t>;

/// Ids of landmarks and the keyframes that observe them, packed: a landmark of ten observations takes about thirteen
/// bytes. For each landmark, in ascending order of ids, these numbers: the difference of its id to the previous one (of
/// the first: to -1), the number of observing keyframes, the difference of the first one's row to that of the previous
/// landmark (of the first: to 0; encoded as 2n for n, as 2n - 1 for -n), and for each further keyframe the difference
/// of its row to the previous one. Numbers are LEB128: seven bits a byte, the lowest first, the eighth bit where more
/// follow. Keyframes without a row are left out.
template <class Landmark>
std::string PackObservers(const std::vector<const Landmark*>& landmarks, const RowOfKeyframe& rows);

/// A standard deviation in one byte, in steps of 5 %: 0 is unknown, 1 is 0.1 mm and less, 255 is 24 m and more.
uint8_t PackSigma(double sigma_m);

/// Limits of the map in a page.
struct MapLimits {
  size_t points = 150'000;
  size_t segments = 30'000;
  size_t edges = 40'000;
  size_t observer_bytes = 1'500'000;  ///< beyond it, only the ids of the landmarks
};

/// Returns the map for the page. If it exceeds the limits, the landmarks with the fewest observing keyframes are left
/// out, and the covisibility edges with the fewest shared landmarks, or the lists of observers; `notes` then says so.
ReportMap MapTables(const Map& map, const MapLimits& limits, std::vector<std::string>* notes);

}  // namespace plslam::viewer
