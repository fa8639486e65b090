// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/map/map.h"

namespace plslam::mapping {

/// Keyframes that a map gives up so that no more than `max_keyframes` are left, in the order in which they should go.
///
/// The oldest of those that a keyframe of a later visit replaces: one that is as near as keyframes of the map
/// follow each other, looks the same way, and came after the camera had left the place, or with another session.
/// So a robot that stays in one building keeps a view of every place, each the newest one. Where no keyframe is
/// replaced, the oldest of all. `is_kept` says which stay in any case; then more than `max_keyframes` may be left.
std::vector<int64_t> KeyframesToForget(const Map& map, size_t max_keyframes,
                                       const std::function<bool(const MapKeyframe&)>& is_kept);

}  // namespace plslam::mapping
