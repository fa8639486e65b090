// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Keyframes around both ends of a loop: the end, its best neighbours (sharing `min_shared` landmarks) and their
/// neighbours, up to a number, none on both sides. Empty if an end is no longer in the map.
struct LoopSides {
  std::vector<KeyframeId> old_side;
  std::vector<KeyframeId> new_side;
};

/// Call this before anything is fused: afterwards both sides are neighbours.
LoopSides SidesOf(const LoopEdge& edge, int min_shared, const Map& map);

/// Fuses each pair of landmarks (PL-SLAM §VI.B), also if an earlier pair has fused one of them with another landmark.
/// Skips pairs of which one no longer exists, or that one keyframe observes separately.
void FusePairs(const std::vector<SameLandmarks>& points, const std::vector<SameLandmarks>& lines,
               const KeyframeFeatures& features, Map& map);

/// Looks for the landmarks of each side in the keyframes of the other. Afterwards a session that began unconnected
/// joins the spanning tree if its first keyframe shares landmarks with older ones.
void MergeSides(const LoopSides& sides, const KeyframeFeatures& features, const StereoCamera& camera,
                const MappingOptions& options, Map& map);

}  // namespace plslam::mapping
