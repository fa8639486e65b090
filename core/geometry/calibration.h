// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/imu.h"
#include "core/geometry/se3.h"

namespace plslam {

/// Largest time from the first row of an image to the last.
inline constexpr double kMaxReadout_ms = 1000.0;

/// A region of a raw image, in its pixels: (0, 0) is the centre of the first one.
struct MaskPolygon {
  std::vector<Eigen::Vector2f> corners_px;
  /// Whether the region is in use, not masked: a hole in the polygons before it.
  bool in_use = false;
  bool operator==(const MaskPolygon&) const = default;
};

/// Masked regions of the images of one frame.
struct FrameMask {
  std::vector<MaskPolygon> left;
  std::vector<MaskPolygon> right;
};

/// Largest number of corners of all polygons of a camera: the masks of both cameras fit one datagram.
inline constexpr size_t kMaxMaskCorners = 2000;

/// Names of the lens models (formulas: core/geometry/distortion.h).
namespace lens_model {
inline constexpr const char* kPinhole = "pinhole";  ///< no distortion
inline constexpr const char* kRadtan = "radtan";
inline constexpr const char* kRational = "rational";
inline constexpr const char* kEquidistant = "equidistant";
inline constexpr const char* kDoubleSphere = "double_sphere";
}  // namespace lens_model

/// Calibration of one camera. `model` is one of `lens_model`.
struct CameraCalibration {
  int width_px = 0;
  int height_px = 0;
  std::string model = lens_model::kPinhole;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  std::vector<double> distortion;
  /// Pose of this camera in the body frame (IMU or rig).
  SE3 T_b_cam;
  /// Masked regions of its images, drawn in order (core/geometry/image_mask.h). Empty if there are none.
  std::vector<MaskPolygon> mask{};
  /// Time from the first row of its images to the last; 0 for a global shutter.
  double readout_ms = 0.0;
};

/// Calibration of a rig as in its dataset; the content of `camera_t`.
struct RigCalibration {
  enum class Kind { kStereo, kRgbd };
  std::string name;
  Kind kind = Kind::kStereo;
  double rate_hz = 0.0;
  CameraCalibration left;
  CameraCalibration right;
  /// RGB-D only: depth units per metre.
  double depth_units_per_m = 0.0;
  /// Distance between the cameras; for RGB-D the virtual baseline of d = b f / Z.
  double baseline_m = 0.0;
  /// The inertial sensor, if there is one.
  std::optional<ImuCalibration> imu{};
};

}  // namespace plslam
