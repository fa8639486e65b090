// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"

namespace plslam::mapping {

/// Sets the endpoints of lines anew where the keyframes that see them have seen them end: each view's ends are laid
/// onto the infinite line, and an end holds where a second view confirms it. Ends at the border of an image say only
/// that the segment goes at least so far. The line itself does not move.
void ExtendAndTrim(const std::vector<int64_t>& line_ids, const KeyframeFeatures& features, const StereoCamera& camera,
                   Map& map);

}  // namespace plslam::mapping
