// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/map/map.h"
#include "core/places/place_recogniser.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// A group of similar keyframes that see the same landmarks, represented by the most similar one.
struct LoopCandidate {
  KeyframeId keyframe_id = -1;
  /// Similarity of that keyframe, and the sum over its group.
  double score = 0.0;
  double group_score = 0.0;
};

/// Returns places that the keyframe may show again, the most similar first (PL-SLAM §VI.A.1). Keyframes that share
/// landmarks with it, their neighbours and the newest of its session are excluded, as are keyframes much less similar
/// than its predecessor, and keyframes that entered the map later (of another robot): these find this one. A group
/// counts once, with its best keyframe.
std::vector<LoopCandidate> FindLoopCandidates(const Map& map, const PlaceRecogniser& places, KeyframeId keyframe_id,
                                              const CandidateOptions& options);

/// Returns the keyframe with which to measure again, from near, a loop that was closed from afar: the old keyframe
/// nearest to this one that shares landmarks with it, at most half as far away as in the last loop of the session.
std::optional<LoopCandidate> FindSecondLook(const Map& map, KeyframeId keyframe_id, const CandidateOptions& options);

/// As `FindLoopCandidates`, for an image that is not in the map: nothing is excluded, and there is no least
/// similarity.
std::vector<LoopCandidate> FindPlaceCandidates(const Map& map, const PlaceRecogniser& places,
                                               const PlaceDescription& description, const CandidateOptions& options,
                                               int max_queried, int max_candidates);

}  // namespace plslam::loop
