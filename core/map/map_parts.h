// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <vector>

#include "core/map/map.h"

namespace plslam {

/// Returns the parts of a map, sessions that no edge of its `MapGraph` connects, as ids of keyframes. Their relative
/// poses are unknown: a session that was never recognised in the map has a frame of its own. The main part is the first
/// one: that with most keyframes for which `is_of_run` holds, then with most keyframes, then with the oldest one. The
/// others follow in the same order.
std::vector<std::set<KeyframeId>> PartsOf(const Map& map, const std::function<bool(const MapKeyframe&)>& is_of_run);

/// Returns a map of these keyframes, the landmarks that they observe, and the loops between them.
Map PartOf(const Map& map, const std::set<KeyframeId>& keyframes);

}  // namespace plslam
