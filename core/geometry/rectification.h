// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/calibration.h"
#include "core/geometry/distortion.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// Mapping between the pixels of a rectified image and its raw image.
class RectifiedView {
 public:
  /// `q_raw_c` rotates directions of the rectified frame c into the frame of the calibrated camera.
  RectifiedView(const CameraCalibration& calibration, const Eigen::Quaterniond& q_raw_c);

  /// Returns the raw pixel of a rectified pixel of `camera`; nullopt behind the camera or beyond the lens model. It may
  /// be outside the raw image.
  std::optional<Eigen::Vector2d> RawPixel(const StereoCamera& camera, const Eigen::Vector2d& rectified_px) const;
  /// The same for many pixels in place (spans of one length). NaN for nullopt.
  void ToRawPixels(const StereoCamera& camera, std::span<double> x, std::span<double> y) const;

  /// Returns the point on the plane z = 1 of the rectified frame for a raw pixel.
  std::optional<Eigen::Vector2d> RectifiedPoint(const Eigen::Vector2d& raw_px) const;

  const CameraCalibration& calibration() const { return calibration_; }
  const Distortion& distortion() const { return distortion_; }

 private:
  CameraCalibration calibration_;
  Distortion distortion_;
  Eigen::Matrix3d R_raw_c_;
};

/// The rectification of a rig to an ideal pair, which all other code uses.
///
/// The x axis of the rectified frame c is the baseline. The rotation about it, the only freedom, is half way between
/// the two optical axes, which minimises the distortion of both images. Focal length and principal point are those of
/// the widest view without an empty border at the size of the left image, magnified at most 1.3 times unless the view
/// would then be wider than 100 degrees (a fisheye of 190 degrees has no rectified image).
///
/// Two cameras, one above the other, are a pair, too: their rectified images are rotated by 90 degrees, x pointing from
/// the left (first) camera to the right (second) one, and as wide as the raw ones are high.
///
/// A pair that is rectified already (all deviations below 0.01 px) is not changed: `identity`.
struct Rectification {
  StereoCamera camera;
  /// Rotation from the rectified left camera (c) to the calibrated left camera (l). They share their centre.
  Eigen::Quaterniond q_l_c = Eigen::Quaterniond::Identity();
  RectifiedView left;
  /// For RGB-D the same as `left`: depth is aligned with the left image.
  RectifiedView right;
  bool identity = false;
};

/// Throws std::runtime_error with one sentence that names the values: sizes that differ or are empty, focal lengths or
/// baselines that are not positive, unknown lens models, cameras behind one another, left and right exchanged, optical
/// axes that diverge.
Rectification Rectify(const RigCalibration& rig);

}  // namespace plslam
