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

/// The rectified camera that a map was made with. Throws std::runtime_error, which names `path`, where the map says
/// nothing of its camera or the values cannot be.
StereoCamera MapCamera(const StoredMap& stored, const std::string& path);

/// What keeps two rectified cameras from being the same: "f_px 458.65 instead of 460.1, ..."; empty where nothing
/// does. Images have the same size, and none of the other numbers moves a point of a disparity up to 100 px by more
/// than 1e-4 px, a thousandth of what features are measured to: a calibration that is written with fewer digits stays
/// the same camera.
std::string CameraDifference(const StereoCamera& was, const StereoCamera& is);
}  // namespace plslam
