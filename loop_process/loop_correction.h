// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// Returns the poses of the keyframes after closing the loop (PL-SLAM §VI.B), ascending by id: of the part of the map
/// that contains the loop, or of the two parts that it joins; other parts do not change. Returns nullopt if the pose
/// graph rejects the loop, or cannot be solved.
///
/// Minimises sum_ij e_ij^T C_ij^-1 e_ij over the poses, the first fixed, with e_ij the error of T_ij^-1 T_w_i^-1 T_w_j
/// (`OptimisePoseGraph`). Edges are the connections between these keyframes (`MapGraph`), measured on the current map,
/// and the loop, the only edge that may be rejected. If no known step connects the two sides, the side that began later
/// starts at the pose that the loop gives it.
std::optional<std::vector<CorrectedPose>> CloseLoop(const Map& map, const LoopEdge& loop,
                                                    const CorrectionOptions& options);

}  // namespace plslam::loop
