// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Keyframes around both ends of a loop: the end, its best neighbours (that share `min_shared` landmarks) and theirs,
/// up to a number, none on both sides. Empty where an end is no longer in the map.
struct LoopSides {
  std::vector<int64_t> old_side;
  std::vector<int64_t> new_side;
};

/// To be asked before anything is fused: afterwards both sides are neighbours.
LoopSides SidesOf(const LoopEdge& edge, int min_shared, const Map& map);

/// Makes one of each pair (PL-SLAM §VI.B), also where one of them has become another landmark by an earlier pair.
/// Pairs of which one is no longer there, or that a keyframe sees apart, stay as they are.
void FusePairs(const std::vector<SameLandmarks>& points, const std::vector<SameLandmarks>& lines,
               const KeyframeFeatures& features, Map& map);

/// Looks for the landmarks of either side in the keyframes of the other. Afterwards a session that began without
/// connection hangs on the spanning tree if its first keyframe shares landmarks with older ones.
void MergeSides(const LoopSides& sides, const KeyframeFeatures& features, const StereoCamera& camera,
                const MappingOptions& options, Map& map);

}  // namespace plslam::mapping
