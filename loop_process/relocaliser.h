// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// Finds the pose of a camera without a prior: verifies the most similar places as loop candidates. Not found if two
/// places far from each other both fit; places without a connecting path in the map do not count as far.
Relocalisation FindCamera(const Map& map, const KeyframeMemory& memory, const FeaturesView& features,
                          const StereoCamera& camera, const LoopOptions& options);

}  // namespace plslam::loop
