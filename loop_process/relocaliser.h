// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"
#include "core/map/loop_closure.h"
#include "core/map/map.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// Where a camera is of which nothing is known: the most similar places, each verified like a loop's old side. Not
/// found where two places far from each other both fit; places in parts of the map that nothing connects do not count
/// as far.
Relocalisation FindCamera(const Map& map, const KeyframeMemory& memory, const FeaturesView& features,
                          const StereoCamera& camera, const LoopOptions& options);

}  // namespace plslam::loop
