// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/landmark_types.h"
#include "core/map/map_update.h"
#include "core/optim/bundle/map_bundle.h"
#include "mapping_process/insertion/visits.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Returns the local bundle adjustment problem (PL-SLAM §V.B): the keyframe, its best neighbours, and the landmarks
/// that at least two keyframes observe. Other observing keyframes are constant, as are those of earlier visits, which
/// define the place, and the first of the map. Twice as wide for the first keyframes of a session that begins among
/// those of another (docs/reliability.md, "What a kill costs").
MapBundle MakeLocalWindow(KeyframeId keyframe_id, const Map& map, const KeyframeFeatures& features,
                          const Visits& visits, const StereoCamera& camera, const WindowOptions& options);

/// Returns the problem of these landmarks with constant keyframes, for use after a global bundle adjustment, which
/// gives poses but no landmarks.
MapBundle MakeLandmarkWindow(const LandmarksNamed& landmarks, const Map& map, const KeyframeFeatures& features,
                             const StereoCamera& camera);

/// Applies the result to the map: poses and landmarks (those not adjusted move with their newest observing keyframe);
/// drops observations that are outliers. Does nothing if the adjustment failed.
AdjustmentFigures ApplyAdjustment(const MapBundle& window, const BundleResult& result,
                                  const KeyframeFeatures& features, Map& map);

}  // namespace plslam::mapping
