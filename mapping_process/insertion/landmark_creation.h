// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Next ids of new landmarks: 0, 1, 2, ... for each feature type.
struct LandmarkIds {
  LandmarkId next_point = 0;
  LandmarkId next_line = 0;
};

/// Ids of the landmarks created with a keyframe.
struct NewLandmarks {
  std::vector<LandmarkId> points;
  std::vector<LandmarkId> lines;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.points, self.lines);
  }
};

/// Creates a landmark, with its covariance, for each feature of the keyframe that observes none and whose depth is
/// accurate enough. Skips segments without length.
NewLandmarks CreateLandmarks(KeyframeId keyframe_id, const FeaturesView& features, const StereoCamera& camera,
                             const InsertionOptions& options, LandmarkIds& ids, Map& map);

}  // namespace plslam::mapping
