// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/stereo_camera.h"
#include "core/io/maps/map_file.h"

namespace plslam::test {

/// The camera of SmallStoredMap.
StereoCamera SmallCamera();

/// Three keyframes in a row that all observe 60 points and 4 lines without any error, with the camera as
/// mapping_process stores it. Point 100 is observed only by keyframe 0. Feature i of every keyframe is point i; one
/// more feature belongs to no landmark.
StoredMap SmallStoredMap();

}  // namespace plslam::test
