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

/// Where the pixels of one rectified image come from.
class RectifiedView {
 public:
  /// `q_raw_c` turns directions of the rectified frame c into the frame of the camera as calibrated.
  RectifiedView(const CameraCalibration& calibration, const Eigen::Quaterniond& q_raw_c);

  /// Pixel of the raw image that a rectified pixel of `camera` shows; nullopt behind the camera or beyond the lens
  /// model. May lie outside the raw image.
  std::optional<Eigen::Vector2d> RawPixel(const StereoCamera& camera, const Eigen::Vector2d& rectified_px) const;
  /// The same of many pixels in place (spans of one length). NaN where there is nothing.
  void ToRawPixels(const StereoCamera& camera, std::span<double> x, std::span<double> y) const;

  /// Point on the plane z = 1 of the rectified frame that a raw pixel shows.
  std::optional<Eigen::Vector2d> RectifiedPoint(const Eigen::Vector2d& raw_px) const;

  const CameraCalibration& calibration() const { return calibration_; }
  const Distortion& distortion() const { return distortion_; }

 private:
  CameraCalibration calibration_;
  Distortion distortion_;
  Eigen::Matrix3d R_raw_c_;
};

/// A rig turned into the ideal pair that everything after works with.
///
/// The x axis of the rectified frame c is the baseline. The only freedom, the turn about it, goes half way between
/// the two optical axes, so that both images are bent as little as possible. Focal length and principal point are the
/// ones of the widest view without an empty border at the size of the left image, magnified at most 1.3 times unless
/// the view would be wider than 100 degrees then (a fisheye of 190 degrees has no rectified image).
///
/// Cameras one above the other are a pair, too: their rectified images are turned by 90 degrees, x pointing from the
/// left (first) camera to the right (second) one, and as wide as the raw ones are high.
///
/// A pair that is rectified already (all sigmas below 0.01 px) passes through untouched: `identity`.
struct Rectification {
  StereoCamera camera;
  /// Left camera as calibrated (l) from rectified left camera (c). They share their centre.
  Eigen::Quaterniond q_l_c = Eigen::Quaterniond::Identity();
  RectifiedView left;
  /// For RGB-D the same as `left`: depth is aligned with the left image.
  RectifiedView right;
  bool identity = false;
};

/// Throws std::runtime_error with one sentence that names the values: sizes that differ or are empty, focal lengths
/// or baselines that are not positive, unknown lens models, cameras behind one another, left and right exchanged,
/// cameras that look apart.
Rectification Rectify(const RigCalibration& rig);

}  // namespace plslam
