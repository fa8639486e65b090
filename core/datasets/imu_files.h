// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/image_list.h"
#include "core/datasets/yaml_map.h"
#include "core/geometry/imu.h"

namespace plslam {

/// Reads a sensor's calibration: the `imu` of a camera.yaml, imu.yaml beside images, EuRoC's `sensor.yaml` and Kalibr's
/// `imu.yaml`, which share the names of the noises. The pose is `T_b_imu` (ASL: `T_BS`) or, with the pose `T_b_left` of
/// the left camera, `T_c_imu`; without any the body is the sensor, as Kalibr has it. The rate is `rate_hz` or
/// `update_rate`. Throws DatasetError that names file, line, key, value and bound.
ImuCalibration ReadImuCalibration(const YamlMap& yaml, const SE3& T_b_left);

/// Reads samples in EuRoC's columns: time in ns, angular rates in rad/s, specific forces in m/s^2. Rows whose time is
/// not after the one before are skipped, with a warning. Throws DatasetError.
std::vector<ImuSample> ReadImuSamples(const std::string& path, Notes* notes);

/// Adds the sensor whose samples are in `csv` to `list`, if there is such a file. Its calibration is that of the list's
/// rig, or else in `yaml`; without either a warning says so, and the samples are not used. Throws DatasetError.
void AddImu(const std::string& csv, const std::string& yaml, ImageList* list);

/// Returns the lines of a camera.yaml for a sensor.
std::string ImuFileText(const ImuCalibration& imu);

}  // namespace plslam
