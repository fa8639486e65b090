// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/map/map.h"
#include "mapping_process/insertion/visits.h"

namespace plslam::mapping {

/// Returns the keyframes to remove so that at most `max_keyframes` are left, in the order of removal.
///
/// First the oldest of those that show what an earlier visit has mapped: more than half of their landmarks have an
/// observation from an earlier visit. The first view of a place therefore stays as long as later visits confirm it, and
/// with it the place itself: a map that kept the newest views instead would inherit the errors of each lap. Then the
/// keyframes whose landmarks have most other observations. Once a landmark has fewer than two observations on average,
/// the oldest: the map then loses places. Keyframes for which `is_kept` is true are never removed; more than
/// `max_keyframes` may then be left.
std::vector<KeyframeId> KeyframesToForget(const Map& map, const Visits& visits, size_t max_keyframes,
                                          const std::function<bool(const MapKeyframe&)>& is_kept);

}  // namespace plslam::mapping
