// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"

namespace plslam::mapping {

/// Updates the endpoints of line landmarks from all their observations: the endpoints of each view are projected onto
/// the infinite 3D line, and the outermost one that a second view confirms is taken. Endpoints at the image border are
/// lower bounds of the extent. The infinite line does not move.
void ExtendAndTrim(const std::vector<LandmarkId>& line_ids, const KeyframeFeatures& features,
                   const StereoCamera& camera, Map& map);

}  // namespace plslam::mapping
