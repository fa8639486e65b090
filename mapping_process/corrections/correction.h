// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"

namespace plslam::mapping {

/// Where each keyframe lies after a correction; keyframes that it does not move are missing. Named ones lie where it
/// says. Others (newer than the map it was computed on) keep their pose relative to their parent in the spanning
/// tree or, where only that one is named, to the keyframe before; and so on from keyframe to keyframe.
std::map<int64_t, SE3> PosesAfter(const std::vector<CorrectedPose>& corrected, const Map& map);

/// Moves keyframes, and each landmark with its anchor (`Map::Move`). A landmark that the keyframes which see it then
/// see worse than before, because they have moved differently, goes with the one that leaves it where all of them see
/// it best: so landmarks that keyframes of both sides of a loop see go with the side that knows them better.
/// Observations that have become impossible (behind the camera) are dropped. Returns the landmarks that were seen
/// worse than before.
LandmarksNamed MoveKeyframes(const std::map<int64_t, SE3>& poses, const KeyframeFeatures& features,
                             const StereoCamera& camera, Map& map);

}  // namespace plslam::mapping
