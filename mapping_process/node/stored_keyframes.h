// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/io/maps/map_file.h"
#include "core/map/keyframe.h"

namespace plslam {

/// The keyframes of a map as trackers send them, for listeners that need their features.
std::vector<Keyframe> KeyframesOf(const StoredMap& stored);

}  // namespace plslam
