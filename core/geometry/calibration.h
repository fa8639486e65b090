#pragma once

#include <string>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// One camera as calibrated. `model` is "pinhole" (no distortion), "radtan" (k1 k2 p1 p2 [k3]) or "equidistant"
/// (k1 k2 k3 k4).
struct CameraCalibration {
  int width_px = 0;
  int height_px = 0;
  std::string model = "pinhole";
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  std::vector<double> distortion;
  /// Body (IMU or rig) from this camera.
  SE3 T_b_cam;
};

/// A rig as its dataset describes it; the content of `camera_t`.
struct RigCalibration {
  enum class Kind { kStereo, kRgbd };
  std::string name;
  Kind kind = Kind::kStereo;
  double rate_hz = 0.0;
  CameraCalibration left;
  CameraCalibration right;
  /// RGB-D only: depth units per metre.
  double depth_units_per_m = 0.0;
  /// Distance of the cameras; for RGB-D the virtual baseline of d = b f / Z.
  double baseline_m = 0.0;
};

}  // namespace plslam
