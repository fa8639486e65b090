#pragma once

#include <string>

#include "core/geometry/stereo_camera.h"
#include "core/io/map_file.h"

namespace plslam {

/// The rectified camera that a map was made with, as mapping_process puts it into the file (`StoredMap::rig`). Throws
/// std::runtime_error, which names `path`, where the map says nothing of its camera or the values cannot be.
StereoCamera MapCamera(const StoredMap& stored, const std::string& path);

}  // namespace plslam
