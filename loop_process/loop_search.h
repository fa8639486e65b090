#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/map.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/loop_candidates.h"
#include "loop_process/loop_verification.h"
#include "loop_process/options.h"

namespace plslam {

/// What was looked at for one keyframe, and what came of it.
struct LoopSearch {
  std::vector<LoopCandidate> candidates;
  /// Of each candidate.
  std::vector<LoopEvidence> evidence;
  /// The loop, if there is one: place in the two.
  std::optional<size_t> best;
};

/// Looks for a loop at a keyframe: candidates, and each verified. Of those accepted the one with most inliers; none where
/// another one with nearly as many says that the camera is elsewhere (another accepted one, or any where the map does not
/// know how the two lie to each other).
LoopSearch FindLoop(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera,
                    const LoopOptions& options, int64_t keyframe_id);

/// Whether two poses of a camera are two places: farther apart than a tenth of the distance to what it sees, or 5 deg.
bool AreTwoPlaces(const FoundPlace& a, const FoundPlace& b);

}  // namespace plslam
