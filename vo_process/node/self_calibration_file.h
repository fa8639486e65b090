// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vo_process/tracking/odometry.h"
#include "vo_process/tracking/self_calibration.h"

namespace plslam::vo {

/// Names a calibration: of an encoded camera_t, whatever its header says. Another calibration has another name.
std::string NameOfCalibration(const std::vector<uint8_t>& camera);

/// YAML, beside the file and renamed. Throws std::runtime_error that names the file.
void WriteSelfCalibration(const std::string& path, const std::string& calibration, const SelfCalibration& learned);

/// nullopt where there is no such file, or what it holds was learned with another calibration. Throws
/// std::runtime_error that names file, key and value where it cannot be read or holds what cannot be.
std::optional<SelfCalibration> ReadSelfCalibration(const std::string& path, const std::string& calibration);

/// Begins a session with what the file says of its camera (an encoded camera_t), if there is one. A file that cannot
/// be used is told, and all is learned anew. Nothing where `path` is empty.
void BeginWithLearned(const std::string& path, const std::vector<uint8_t>& camera, Odometry& odometry);

/// Keeps what is believed now; where nothing is, an older file stays. A file that cannot be written is told.
void KeepLearned(const std::string& path, const std::vector<uint8_t>& camera, const Odometry& odometry);

}  // namespace plslam::vo
