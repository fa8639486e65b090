// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/datasets/imu_parts.h"
#include "core/files/notes.h"
#include "core/geometry/calibration.h"

namespace plslam {

/// A camera's `sensor.yaml` of the ASL format: T_BS, resolution, camera_model (pinhole), intrinsics (fu fv cu cv),
/// distortion_model (radial-tangential, equidistant or none), distortion_coefficients. Throws DatasetError.
CameraCalibration ReadAslCamera(const std::string& path);

/// Left and right camera of a `camchain.yaml` as Kalibr writes it: cam0, cam1 ... , each with T_cam_imu (the inverse of
/// T_BS; T_cn_cnm1, from the camera before, does too; without an IMU the body is cam0) or OpenVINS' T_imu_cam,
/// distortion_coeffs, and the rest as above. The camera model `ds` (double sphere) is read too. ChoosePair selects two
/// of several cameras, and `notes` names them. Throws DatasetError.
std::pair<CameraCalibration, CameraCalibration> ReadCamchain(const std::string& path, Notes* notes);

/// Reads what a `camchain.yaml` states about the IMU: its pose, since it is the body, and its time offset by
/// `timeshift_cam_imu` of the left camera (t_imu = t_cam + shift,
/// https://github.com/ethz-asl/kalibr/wiki/yaml-formats). Throws DatasetError.
ImuParts ReadCamchainImu(const std::string& path);

}  // namespace plslam
