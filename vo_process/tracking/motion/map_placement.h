// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/stereo_camera.h"
#include "core/motion/options.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/landmarks/tracker_local_map.h"

namespace plslam::vo {

/// Returns T_w_odom such that the landmarks of the map project to the pixels of the tracker's landmarks that are the
/// same, for the camera at `T_odom_c`: adopting them then leaves T_odom_c unchanged, except as far as they have moved
/// relative to each other. `local_map.T_w_odom` is where the search begins. Returns nullopt if
/// fewer than `min_weight` (points + 2 x lines) landmarks in view are the same, or less than half of them agree.
///
/// The newest keyframe of the map is no measure of it: its pose in odom was found among landmarks as they were adopted
/// before it, and those of its successor may have been adopted elsewhere.
std::optional<SE3> PlacementInMap(const LocalLandmarks& landmarks, const TrackerLocalMap& local_map,
                                  const SE3& T_odom_c, const StereoCamera& camera, const MotionOptions& motion,
                                  int min_weight);

}  // namespace plslam::vo
