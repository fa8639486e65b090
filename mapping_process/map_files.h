#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/io/map_file.h"
#include "core/map/keyframe.h"

namespace plslam {

/// The rectified camera of a map, for its file (little endian doubles).
std::vector<uint8_t> CameraBytes(const StereoCamera& camera);

/// The rectified camera that a map was made with must be this one, since its keyframes are seen through it. Throws
/// std::runtime_error with one sentence that names the file and what differs.
void CheckCamera(const StoredMap& stored, const StereoCamera& camera, const std::string& path);

/// The keyframes of a map as trackers send them, for listeners that need their features.
std::vector<Keyframe> KeyframesOf(const StoredMap& stored);

}  // namespace plslam
