// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/datasets/image_list.h"
#include "core/datasets/imu_parts.h"
#include "core/geometry/imu.h"

namespace plslam {

/// Reads what a file states about a sensor: the keys of `ReadImuParts`, in a file of their own, below `imu` (so in a
/// camera.yaml) or below `imu0` (Kalibr, OpenVINS), or the settings of another program (calibrations/), also those that
/// a camera.yaml names by `from`. A camera.yaml without a sensor, and a missing file, state nothing. Throws
/// DatasetError.
ImuParts ReadImuFile(const std::string& path, OtherKeys other, Notes* notes);

/// Returns the sensor that a camera file describes; nullopt without its pose. A sensor without one is the body if the
/// left camera has a pose in it, as Kalibr has it.
std::optional<ImuCalibration> CompleteImu(const ImuParts& parts, const SE3& T_b_left);

/// Sources of the calibration of a sensor whose samples come from elsewhere.
struct ImuSources {
  /// Files as `ReadImuFile` reads them, the first that states a property is decisive; missing ones state nothing.
  std::vector<std::string> files{};
  /// Pose of the sensor in the left camera, by the transforms of the robot.
  std::optional<SE3> T_c_imu{};
  /// The poses of the cameras are those of a camera file, and so refer to the body of that file.
  bool has_camera_file = false;
  OtherKeys other = OtherKeys::kRefused;
};

/// Returns the calibration of such a sensor beside the cameras of `rig`. The pose is that of a file, or else that of
/// the transforms; files without a pose mean that the sensor is the body if a camera file has a pose of the left camera
/// in it (Kalibr). Returns nullopt without any. `notes` receives a remark on a noise that is not stated, for the sensor
/// `name`. Throws DatasetError.
std::optional<ImuCalibration> FindImuCalibration(const std::string& name, const RigCalibration& rig,
                                                 const ImuSources& sources, Notes* notes);

/// Reads samples in EuRoC's columns: time in ns, angular rates in rad/s, specific forces in m/s^2. Rows whose time is
/// not after the one before are skipped, with a warning. Throws DatasetError, also for times in another unit.
std::vector<ImuSample> ReadImuSamples(const std::string& path, Notes* notes);

/// Returns the reason why samples of a sensor, at least one, do not belong to images from `first_ns` to `last_ns`: none
/// is of their time. Empty if they do.
std::string OtherTimesComplaint(const std::vector<ImuSample>& samples, const ImuCalibration& imu, int64_t first_ns,
                                int64_t last_ns);

/// Sets the sensor of the list's rig whose samples are in `csv`, if there is such a file, as `FindImuCalibration`; the
/// list has its entries. Without a calibration or a pose, and if no sample is of the time of the images, a warning says
/// so with the remedy, a file `own`, and there is no sensor. Throws DatasetError.
void AddImu(const std::string& csv, const std::string& own, const ImuSources& sources, ImageList* list);

/// Returns the lines of a camera.yaml for a sensor.
std::string ImuFileText(const ImuCalibration& imu);

}  // namespace plslam
