// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "core/datasets/yaml_map.h"
#include "core/files/notes.h"
#include "core/geometry/imu.h"
#include "core/geometry/se3.h"

namespace plslam {

/// The content of one file about an inertial sensor; other files may state the rest.
struct ImuParts {
  bool is_stated = false;  ///< whether the file is about a sensor at all
  std::optional<SE3> T_b_imu;
  std::optional<SE3> T_c_imu;  ///< in the left camera, instead
  std::optional<ImuNoise> noise;
  std::optional<double> time_offset_s;
  std::optional<double> rate_hz;

  bool has_pose() const { return T_b_imu || T_c_imu; }
  /// Takes from another file what this one does not state.
  void Complete(const ImuParts& other);
};

/// Keys that a program has for the properties of a sensor.
struct ImuKeys {
  /// Densities of the noise of rates, of the walk of their bias, of the noise of forces, and of the walk of theirs, in
  /// SI units per root of Hz; each one number, or one for each axis, of which the largest is used.
  std::array<const char*, 4> noise;
  const char* rate = nullptr;
  const char* time = nullptr;
  /// `ImuCalibration::time_offset_s` for a value of 1 of that key.
  double time_offset_s = 1.0;
};

/// Reads the noise if one of its keys is there (then all must be), the rate and the time offset. Throws DatasetError
/// that names file, line, key, value and bound.
ImuParts ReadImuKeys(const YamlMap& yaml, const ImuKeys& keys);

enum class OtherKeys { kRefused, kIgnored };

/// Reads the keys of docs/imu.md, of Kalibr's `imu.yaml`, and of `sensor.yaml` of the ASL format and of Kimera, which
/// share the names of the noises. The pose is `T_b_imu` (ASL: `T_BS`), or `T_c_imu` in the left camera. The rate is
/// `rate_hz` or `update_rate`. `time_offset_s` is added to stamps of the sensor; Kimera's `imu_time_shift` has the
/// opposite sign (t_imu = t_cam + shift: Kimera-VIO, TimeAlignerBase.h). Keys of other meaning are refused if `other`
/// says so, but not beside `T_BS`. `notes` receives a warning on scale and misalignment, which are not applied. Throws
/// DatasetError.
ImuParts ReadImuParts(const YamlMap& yaml, OtherKeys other, Notes* notes);

}  // namespace plslam
