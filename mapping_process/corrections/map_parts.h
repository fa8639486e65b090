#pragma once

#include <cstdint>
#include <set>

#include "core/map/map.h"

namespace plslam {

/// Keyframes that a keyframe of the map is connected with, itself among them: by the spanning tree, by the keyframe before in
/// its session, or by loops. A session that began without connection is a part of its own until something ties it.
std::set<int64_t> PartOf(int64_t keyframe_id, const Map& map);

}  // namespace plslam
