// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace plslam {

/// Position and size of an image in the image plane of a camera, which need not be the one that took it.
struct TakenImage {
  int left_px = 0;
  int top_px = 0;
  int width_px = 0;
  int height_px = 0;
  /// Focal length with which it was taken: octaves refer to its pixels then.
  double f_px = 0.0;

  bool operator==(const TakenImage&) const = default;
};

/// A rectified stereo pair: one focal length, one principal point, the right camera `baseline_m` along +x of the left.
///
/// Camera frame c: x right, y down, z forward. A stereo measurement is (u, v, d): left pixel and disparity
/// d = u_left - u_right = f b / Z. Pixel centres have integer coordinates.
struct StereoCamera {
  double f_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  double baseline_m = 0.0;
  int width_px = 0;
  int height_px = 0;
  /// Origin of its image, and the focal length with which this was taken (0: its own); not zero only if features of one
  /// camera are expressed in another (`FeaturesInCamera`).
  int left_px = 0;
  int top_px = 0;
  double taken_f_px = 0.0;

  bool operator==(const StereoCamera&) const = default;

  TakenImage image() const { return {left_px, top_px, width_px, height_px, taken_f_px > 0.0 ? taken_f_px : f_px}; }
  /// Returns the same camera with another image.
  StereoCamera With(const TakenImage& image) const {
    return {f_px, cx_px, cy_px, baseline_m, image.width_px, image.height_px, image.left_px, image.top_px, image.f_px};
  }
  /// Factor of the distance from which this camera would detect a corner in the octave in which its image shows it.
  double OctaveScale() const { return f_px / image().f_px; }

  double FocalBaseline() const { return f_px * baseline_m; }
  double Depth(double disparity_px) const { return FocalBaseline() / disparity_px; }
  /// Depth at a disparity of four focal lengths: nearer than a pair can see. Relative to the baseline, so that it fits
  /// rigs of millimetres and of metres.
  double MinDepth() const { return std::max(1e-6, 0.25 * baseline_m); }

  /// Returns the left pixel of a point, which must be in front of the camera (z > 0).
  Eigen::Vector2d Project(const Eigen::Vector3d& p_c) const {
    const double k = f_px / p_c.z();
    return {k * p_c.x() + cx_px, k * p_c.y() + cy_px};
  }

  /// Returns (u, v, disparity) of a point in front of the camera.
  Eigen::Vector3d ProjectStereo(const Eigen::Vector3d& p_c) const {
    const Eigen::Vector2d uv = Project(p_c);
    return {uv.x(), uv.y(), FocalBaseline() / p_c.z()};
  }

  /// Derivative of `ProjectStereo` by the point.
  Eigen::Matrix3d ProjectStereoJacobian(const Eigen::Vector3d& p_c) const;

  /// Returns the point of a measurement (u, v, d) with d > 0, in the left camera.
  Eigen::Vector3d Backproject(const Eigen::Vector3d& uvd) const {
    const double z = Depth(uvd.z());
    return {(uvd.x() - cx_px) * z / f_px, (uvd.y() - cy_px) * z / f_px, z};
  }

  /// Covariance of `Backproject` for independent errors of u and v (`sigma_px`) and of d (`sigma_disparity_px`).
  Eigen::Matrix3d BackprojectCovariance(const Eigen::Vector3d& uvd, double sigma_px, double sigma_disparity_px) const;

  bool InImage(const Eigen::Vector2d& px, double margin_px) const {
    return px.x() >= left_px + margin_px && px.y() >= top_px + margin_px &&
           px.x() <= left_px + width_px - 1 - margin_px && px.y() <= top_px + height_px - 1 - margin_px;
  }
};

}  // namespace plslam
