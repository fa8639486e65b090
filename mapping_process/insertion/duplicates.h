// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/stereo_camera.h"
#include "core/localisation/local_map.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Looks for a keyframe's landmarks in its neighbours and for the neighbours' landmarks in it (PL-SLAM §V.A), by
/// projection. A feature without a landmark becomes an observation; if it observes another landmark near by, the two
/// landmarks are fused.
void MergeWithNeighbours(KeyframeId keyframe_id, const KeyframeFeatures& features, const StereoCamera& camera,
                         const MappingOptions& options, Map& map);

/// Search window for landmarks seen from another part of the map.
struct MergeWindow {
  double radius_px = 4.0;
  /// Misalignment of the two parts, as an angle at the landmark's distance, added to the landmarks' covariances.
  double sigma_px = 0.0;
};

/// Looks for landmarks in a keyframe that does not observe them yet, as above.
void MergeInto(KeyframeId keyframe_id, const LocalMap& landmarks, const MergeWindow& window,
               const KeyframeFeatures& features, const StereoCamera& camera, const LocalisationOptions& options,
               Map& map);

}  // namespace plslam::mapping
