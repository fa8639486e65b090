// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/datasets/image_list.h"
#include "core/datasets/yaml_map.h"
#include "core/geometry/imu.h"

namespace plslam {

/// Reads a sensor's calibration: the `imu` of a camera.yaml, imu.yaml beside images, EuRoC's `sensor.yaml` and
/// Kalibr's `imu.yaml`, which share the names of the noises. The pose is `T_b_imu` (ASL: `T_BS`) or, with the pose
/// `T_b_left` of the left camera, `T_c_imu`; without any the body is the sensor, as Kalibr has it. Without any noise,
/// that of a sensor without a data sheet is used, with a remark. The rate is `rate_hz` or `update_rate`. Throws
/// DatasetError that names file, line, key, value and bound.
ImuCalibration ReadImuCalibration(const YamlMap& yaml, const SE3& T_b_left, Notes* notes);

/// Sources of the calibration of a sensor whose samples come from a recording or from a robot.
struct ImuSources {
  /// File with the key `imu`, or with the keys of one; empty, or missing: none.
  std::string file;
  /// Pose of the sensor in the left camera, by the transforms of the robot.
  std::optional<SE3> T_c_imu;
  /// The poses of the cameras are those of a camera file, and so refer to the body of that file.
  bool has_camera_file = false;
};

/// Returns the calibration of such a sensor beside the cameras of `rig`. The pose is that of the file, or else that of
/// the transforms; a file without a pose means that the sensor is the body if a camera file has a pose of the left
/// camera in it (Kalibr). Returns nullopt without any. `notes` receives a remark on a noise that is not stated, for the
/// sensor `name`. Throws DatasetError.
std::optional<ImuCalibration> FindImuCalibration(const std::string& name, const RigCalibration& rig,
                                                 const ImuSources& sources, Notes* notes);

/// Reads samples in EuRoC's columns: time in ns, angular rates in rad/s, specific forces in m/s^2. Rows whose time is
/// not after the one before are skipped, with a warning. Throws DatasetError.
std::vector<ImuSample> ReadImuSamples(const std::string& path, Notes* notes);

/// Adds the sensor whose samples are in `csv` to `list`, if there is such a file. Its calibration is that of the list's
/// rig, or else in `yaml`; without either a warning says so, and the samples are not used. Throws DatasetError.
void AddImu(const std::string& csv, const std::string& yaml, ImageList* list);

/// Returns the lines of a camera.yaml for a sensor.
std::string ImuFileText(const ImuCalibration& imu);

}  // namespace plslam
