// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/landmark_types.h"
#include "core/map/map_update.h"
#include "core/optim/bundle/map_bundle.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// The keyframe, its best neighbours and the landmarks they see, at least two keyframes each (PL-SLAM §V.B); other
/// keyframes that see those are constant, and so is the first of the map. Twice as wide for the first keyframes of
/// a session that begins among those of another (docs/reliability.md, "What a kill costs").
MapBundle MakeLocalWindow(int64_t keyframe_id, const Map& map, const KeyframeFeatures& features,
                          const StereoCamera& camera, const WindowOptions& options);

/// These landmarks of the map, and the keyframes that see them, constant: poses are known better than the places of
/// the landmarks (after an adjustment of the whole map that somebody else has made).
MapBundle MakeLandmarkWindow(const LandmarksNamed& landmarks, const Map& map, const KeyframeFeatures& features,
                             const StereoCamera& camera);

/// Takes the result over into the map: poses, landmarks (those that were not adjusted move with the newest keyframe
/// that sees them), and observations that turned out wrong are dropped. Nothing where the adjustment failed.
AdjustmentFigures ApplyAdjustment(const MapBundle& window, const BundleResult& result,
                                  const KeyframeFeatures& features, Map& map);

}  // namespace plslam::mapping
