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

/// What was looked at for one keyframe, and what came of it.
struct LoopSearch {
  std::vector<LoopCandidate> candidates;
  /// Of each candidate.
  std::vector<LoopEvidence> evidence;
  /// The loop, if there is one: place in the two.
  std::optional<size_t> best;
};

/// Looks for a loop at a keyframe: candidates, and each verified. Of those accepted the one with most inliers, if
/// there are any among those whose way to the keyframe the map knows; none where a rival says that the camera is
/// elsewhere (another accepted one, or any where the map does not know how the two lie to each other).
LoopSearch FindLoop(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera,
                    const LoopOptions& options, int64_t keyframe_id);

/// Whether a camera was found at another place nearly as well as at the best. `paths_to_best` are those to the
/// keyframe near which it was best found: between parts of the map that nothing connects poses say nothing about each
/// other, and both may show the place.
bool IsRival(const FoundPlace& best, const FoundPlace& other, int64_t other_keyframe_id, MapPaths& paths_to_best,
             const RelocalisationOptions& options);

}  // namespace plslam::loop
