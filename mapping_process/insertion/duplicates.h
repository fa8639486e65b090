// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/stereo_camera.h"
#include "core/localisation/local_map.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Looks for a keyframe's landmarks in its neighbours and for the neighbours' landmarks in it (PL-SLAM §V.A), by
/// projection: a feature that shows none yet is one more observation; where it shows another landmark near by, the
/// two are one.
void MergeWithNeighbours(int64_t keyframe_id, const KeyframeFeatures& features, const StereoCamera& camera,
                         const MappingOptions& options, Map& map);

/// How landmarks are searched in a keyframe that another part of the map has seen them from.
struct MergeWindow {
  double radius_px = 4.0;
  /// How far the two parts may lie apart, as an angle at the landmark's depth; on top of the landmarks' covariances.
  double sigma_px = 0.0;
};

/// Looks for landmarks in a keyframe that does not see them, as above.
void MergeInto(int64_t keyframe_id, const LocalMap& landmarks, const MergeWindow& window,
               const KeyframeFeatures& features, const StereoCamera& camera, const LocalisationOptions& options,
               Map& map);

}  // namespace plslam::mapping
