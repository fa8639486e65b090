#pragma once

#include <string>

#include "core/geometry/calibration.h"

namespace plslam {

/// A camera's `sensor.yaml` of the ASL format: T_BS, resolution, camera_model (pinhole), intrinsics (fu fv cu cv),
/// distortion_model (radial-tangential, equidistant or none), distortion_coefficients. Throws DatasetError.
CameraCalibration ReadAslCamera(const std::string& path);

}  // namespace plslam
