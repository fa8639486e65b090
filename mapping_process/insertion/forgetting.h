// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/map/map.h"

namespace plslam::mapping {

/// Returns the keyframes to remove so that at most `max_keyframes` are left, in the order of removal.
///
/// First the oldest of those replaced by a later visit: by a keyframe at most one step between keyframes away, with a
/// similar viewing direction, of another session or made after the camera had left the place. A robot that stays in
/// one building thus keeps the newest view of every place. Then the oldest of all others. Keyframes for which `is_kept`
/// is true are never removed; more than `max_keyframes` may then be left.
std::vector<int64_t> KeyframesToForget(const Map& map, size_t max_keyframes,
                                       const std::function<bool(const MapKeyframe&)>& is_kept);

}  // namespace plslam::mapping
