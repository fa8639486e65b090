// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/map.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/loop_candidates.h"
#include "loop_process/loop_verification.h"
#include "loop_process/map_path.h"
#include "loop_process/options.h"
#include "loop_process/place_search.h"

namespace plslam::loop {

/// Candidates of one keyframe and the result of their verification.
struct LoopSearch {
  std::vector<LoopCandidate> candidates;
  /// One for each candidate.
  std::vector<LoopEvidence> evidence;
  /// Index of the loop in both, if there is one.
  std::optional<size_t> best;
};

/// Looks for a loop at a keyframe and verifies each candidate. Chooses the accepted one with most inliers, first among
/// those that a path in the map connects with the keyframe. There is none if a rival puts the camera elsewhere: another
/// accepted candidate, or, if the best is not connected, any candidate.
LoopSearch FindLoop(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera,
                    const LoopOptions& options, KeyframeId keyframe_id);

/// Whether a camera was found at another place nearly as well as at the best. `paths_to_best` lead to the keyframe of
/// the best place: poses of parts of the map without a connecting path cannot be compared, and both may show the same
/// place.
bool IsRival(const FoundPlace& best, const FoundPlace& other, KeyframeId other_keyframe_id, MapPaths& paths_to_best,
             const RelocalisationOptions& options);

}  // namespace plslam::loop
