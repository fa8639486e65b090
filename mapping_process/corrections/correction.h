// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"
#include "core/map/loop_closure.h"

namespace plslam::mapping {

/// Returns the pose of each keyframe after a correction; keyframes that do not move are missing. Listed keyframes get
/// the listed pose. Others (newer than the map on which it was computed) keep their pose relative to their parent in
/// the spanning tree or, if only that one is listed, to their predecessor; and recursively from these.
std::map<KeyframeId, SE3> PosesAfter(const std::vector<CorrectedPose>& corrected, const Map& map);

/// Moves keyframes, and each landmark with its anchor (`Map::Move`). If the reprojection error of a landmark grows,
/// because its observing keyframes have moved differently, it moves with the one of them that minimises its summed
/// squared error: landmarks seen from both sides of a loop follow the side that determines them better. Drops
/// observations that have become impossible (behind the camera). Returns the landmarks whose error had grown.
LandmarksNamed MoveKeyframes(const std::map<KeyframeId, SE3>& poses, const KeyframeFeatures& features,
                             const StereoCamera& camera, Map& map);

}  // namespace plslam::mapping
