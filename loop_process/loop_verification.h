// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/map_path.h"
#include "loop_process/options.h"
#include "loop_process/place_search.h"

namespace plslam::loop {

/// Nearest distance that tolerances are scaled by.
inline constexpr double kNearestScale_m = 1.0;

/// How far a candidate came, for reports and tests.
enum class LoopVerdict {
  kAccepted,
  kNotFound,     ///< no pose among the landmarks of the old place
  kFewInliers,   ///< too few, too small a share, or in one corner of the image
  kOneSided,     ///< the old keyframe is not found among the landmarks of the new, or elsewhere
  kUnconfirmed,  ///< too few of the keyframes before agree
  kBeyondDrift,  ///< the map would have to be more wrong than it can be
  kPaperGates,   ///< one of the paper's three tests failed
};

const char* LoopVerdictName(LoopVerdict verdict);

/// A candidate and what was found out about it.
struct LoopEvidence {
  LoopVerdict verdict = LoopVerdict::kNotFound;
  LoopEdge edge;
  FoundPlace place;
  /// Landmarks seen from both sides: a of the old place, b of the new, each at most once.
  std::vector<SameLandmarks> points;
  std::vector<SameLandmarks> lines;
  int reverse_inliers = 0;
  /// Keyframes that agree, this one included.
  int confirming = 0;
  /// Whether the map knew how both lie to each other, and how far that is off, in drift's chi-square;
  /// below the gate an upper bound of it.
  bool connected = false;
  double drift_chi2 = 0.0;
};

/// Whether a keyframe sees the place of an old one, and how both lie to each other (PL-SLAM §VI.A.2). `paths` are
/// those to the keyframe.
///
/// Default gates: the correction is within what the path between both may have drifted; enough inliers over the image
/// and a fair share of what should be seen, a larger one where no path tells; the old keyframe is found among the
/// landmarks of the new one at the same place; and the keyframes before are found where odometry says they must be,
/// unless there are so many inliers that they need not.
LoopEvidence VerifyLoop(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera,
                        const LoopOptions& options, MapPaths& paths, int64_t old_keyframe_id, int64_t keyframe_id);

}  // namespace plslam::loop
