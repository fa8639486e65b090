// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/map/map.h"
#include "core/places/place_recogniser.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// A place that looks like the keyframe: the most similar keyframe of a group that sees the same landmarks.
struct LoopCandidate {
  int64_t keyframe_id = -1;
  /// Its own similarity, and the sum over its group.
  double score = 0.0;
  double group_score = 0.0;
};

/// Places that may be seen again in a keyframe, the most similar first (PL-SLAM §VI.A.1). Keyframes that share
/// landmarks with it, their neighbours and the newest of its session are none; nor is what is much less similar than
/// the keyframe before, nor what came into the map after it (another robot's): that one finds this one. A group
/// counts once, with its best keyframe.
std::vector<LoopCandidate> FindLoopCandidates(const Map& map, const PlaceRecogniser& places, int64_t keyframe_id,
                                              const CandidateOptions& options);

/// A loop that was closed from afar is measured again from near, once its place is reached: the old keyframe nearest
/// to this one, where it shares landmarks with it by now and is at most half as far as that of the session's last
/// loop was.
std::optional<LoopCandidate> FindSecondLook(const Map& map, int64_t keyframe_id, const CandidateOptions& options);

/// The same as `FindLoopCandidates` for an image that is not of the map: nothing excluded, nothing to compare the
/// similarity with.
std::vector<LoopCandidate> FindPlaceCandidates(const Map& map, const PlaceRecogniser& places,
                                               const PlaceDescription& description, const CandidateOptions& options,
                                               int max_queried, int max_candidates);

}  // namespace plslam::loop
