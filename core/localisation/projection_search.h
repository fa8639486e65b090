// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/localisation/options.h"
#include "core/map/landmark_types.h"

namespace plslam {

/// A landmark and the feature that matches it.
struct LandmarkFeature {
  LandmarkId landmark_id = -1;
  int feature = -1;
};

/// Searches landmarks among the features with `eligible` not zero: each within `radius_px` of its projection into the
/// keyframe at `T_w_kf`, by descriptor, mutual best. `camera` is that of the features (`CameraOf`).
std::vector<LandmarkFeature> SearchPoints(const Map& map, const std::vector<LandmarkId>& ids, const SE3& T_w_kf,
                                          std::span<const StereoPoint> features, const std::vector<char>& eligible,
                                          double radius_px, const StereoCamera& camera,
                                          const LocalisationOptions& options);
/// Sibling of `SearchPoints`.
std::vector<LandmarkFeature> SearchLines(const Map& map, const std::vector<LandmarkId>& ids, const SE3& T_w_kf,
                                         std::span<const StereoLine> features, const std::vector<char>& eligible,
                                         double radius_px, const StereoCamera& camera,
                                         const LocalisationOptions& options);

}  // namespace plslam
