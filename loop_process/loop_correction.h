// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// Where keyframes lie when the loop is closed (PL-SLAM §VI.B): those of the part of the map that it is in, or of the
/// two that it joins, ascending; other parts have nothing to do with it. nullopt where the pose graph contradicts the
/// loop, or cannot be solved.
///
/// Nodes of the graph are these keyframes, the first fixed; edges what connects them (`MapGraph`) as the map has it
/// now, and the loop, which alone may be rejected. Where nothing that is known ties the two sides of the loop, the
/// side that began later starts where the loop puts it.
std::optional<std::vector<CorrectedPose>> CloseLoop(const Map& map, const LoopEdge& loop,
                                                    const CorrectionOptions& options);

}  // namespace plslam::loop
