// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vo_process/tracking/calibration/self_calibration.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {

/// Returns a name of the calibration in an encoded camera_t, independent of its header. Names differ if calibrations
/// do.
std::string NameOfCalibration(const std::vector<uint8_t>& camera);

/// Writes YAML to a temporary file, and renames it. Throws std::runtime_error that names the file.
void WriteSelfCalibration(const std::string& path, const std::string& calibration, const SelfCalibration& learned);

/// Returns nullopt if there is no such file, or if it was learned with another calibration. Throws std::runtime_error
/// that names file, key and value if it cannot be read or has impossible values.
std::optional<SelfCalibration> ReadSelfCalibration(const std::string& path, const std::string& calibration);

/// Begins a session with the file's self-calibration for this camera (an encoded camera_t), if there is one. Logs a
/// warning, and starts without, if the file is unusable. Does nothing if `path` is empty.
void LoadLearned(const std::string& path, const std::vector<uint8_t>& camera, Odometry& odometry);

/// Writes the current self-calibration; without one, keeps an older file. Logs a warning if writing fails.
void KeepLearned(const std::string& path, const std::vector<uint8_t>& camera,
                 const std::optional<Odometry>& odometry);

}  // namespace plslam::vo
