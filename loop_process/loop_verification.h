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

/// Least distance of landmarks by which tolerances are scaled.
inline constexpr double kNearestScale_m = 1.0;

/// Result of a verification, for reports and tests.
enum class LoopVerdict {
  kAccepted,
  kNotFound,     ///< no pose from the landmarks of the old place
  kFewInliers,   ///< too few, too small a share, or in one corner of the image
  kOneSided,     ///< the old keyframe is not found from the landmarks of the new one, or at another pose
  kUnconfirmed,  ///< too few of the previous keyframes agree
  kBeyondDrift,  ///< the correction exceeds the expected drift
  kTilted,       ///< the verticals of the two keyframes contradict the relative pose
  kPaperGates,   ///< one of the paper's three tests failed
};

const char* LoopVerdictName(LoopVerdict verdict);

/// A candidate and its verification.
struct LoopEvidence {
  LoopVerdict verdict = LoopVerdict::kNotFound;
  LoopEdge edge;
  FoundPlace place;
  /// Landmarks seen from both sides: a from the old place, b from the new one, each at most once.
  std::vector<SameLandmarks> points;
  std::vector<SameLandmarks> lines;
  int reverse_inliers = 0;
  /// Consecutive keyframes that agree, this one included.
  int confirming = 0;
  /// Whether a path in the map connects the two keyframes, and the correction's chi-square (6 degrees of freedom) under
  /// the drift along it; an upper bound if below the gate.
  bool connected = false;
  double drift_chi2 = 0.0;
};

/// Verifies that a keyframe shows the place of an old one, and measures their relative pose (PL-SLAM §VI.A.2). `paths`
/// lead to the keyframe.
///
/// Default gates: the correction c = Log(T_map^-1 T_measured) passes the chi-square test c^T C^-1 c under the drift
/// along the path between both; there are enough inliers, spread over the image, and a fair share of the expected
/// landmarks (a larger one without a path); the verticals that an inertial sensor measured from both keyframes agree;
/// the old keyframe is found from the landmarks of the new one at the same relative pose; and previous keyframes are
/// found where odometry predicts them, unless there are very many inliers.
LoopEvidence VerifyLoop(const Map& map, const KeyframeMemory& memory, const StereoCamera& camera,
                        const LoopOptions& options, MapPaths& paths, KeyframeId old_keyframe_id,
                        KeyframeId keyframe_id);

}  // namespace plslam::loop
