#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/io/maps/map_file.h"

namespace plslam {

/// The rectified camera of a map, for its file (`StoredMap::rig`): focal length, principal point, baseline, width, height as
/// little endian doubles.
std::vector<uint8_t> CameraBytes(const StereoCamera& camera);

/// The rectified camera that a map was made with. Throws std::runtime_error, which names `path`, where the map says nothing
/// of its camera or the values cannot be.
StereoCamera MapCamera(const StoredMap& stored, const std::string& path);

/// The rectified camera that a map was made with must be this one to the last bit, since its keyframes are seen through it.
/// Throws std::runtime_error with one sentence that names the file and what differs.
void CheckCamera(const StoredMap& stored, const StereoCamera& camera, const std::string& path);

}  // namespace plslam
