// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

#include "core/geometry/se3.h"

namespace plslam {

/// An area of an image as recorded, in its pixels: (0, 0) is the centre of the first one.
struct MaskPolygon {
  std::vector<Eigen::Vector2f> corners_px;
  /// Not left out, but in use: a hole in the polygons before it.
  bool in_use = false;
  bool operator==(const MaskPolygon&) const = default;
};

/// What is left out of the images of one frame.
struct FrameMask {
  std::vector<MaskPolygon> left;
  std::vector<MaskPolygon> right;
};

/// Corners of all polygons of a camera, at most: the masks of both cameras travel in one datagram.
inline constexpr size_t kMaxMaskCorners = 2000;

/// One camera as calibrated. `model` is a name of core/geometry/distortion.h: "pinhole" (no distortion), "radtan",
/// "rational", "equidistant" or "double_sphere".
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
  /// What is left out of its images, drawn one over the other (core/geometry/image_mask.h). Where nothing is: empty.
  std::vector<MaskPolygon> mask{};
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
