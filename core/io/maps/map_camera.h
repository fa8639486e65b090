// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/io/maps/map_file.h"

namespace plslam {

/// The rectified camera of a map, for its file (`StoredMap::rig`): focal length, principal point, baseline, width,
/// height as little endian doubles.
std::vector<uint8_t> CameraBytes(const StereoCamera& camera);

/// Returns the rectified camera with which a map was made. Throws std::runtime_error, which names `path`, if the map
/// has no camera or its values are invalid.
StereoCamera MapCamera(const StoredMap& stored, const std::string& path);

/// Returns the differences of two rectified cameras: "f_px 458.65 instead of 460.1, ..."; empty if they are the same.
/// The same camera means: images of the same size, and no other number moves a point of a disparity up to 100 px by
/// more than 1e-4 px, a thousandth of the accuracy of features; a calibration that is written with fewer digits stays
/// the same camera.
std::string CameraDifference(const StereoCamera& was, const StereoCamera& is);
}  // namespace plslam
