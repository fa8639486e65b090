// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/features/features.h"
#include "core/geometry/rectification.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"

namespace plslam::vo {

/// When the rows of a pair are observed, as shares of the readout after the time stamp: of the row of a pixel in the
/// left image, and of the row of its match in the right one. Rows are those of the raw images, so the shares of a match
/// differ where rectification moves them.
struct RowShares {
  double left = 0.0;
  double right = 0.0;
};

/// Cameras that read the rows of their images one after the other. The row that the time stamp refers to is the
/// reference of both cameras:
///
///   time of a pixel = time stamp + (raw row / rows - share of the stamp) * readout.
///
/// With the camera's velocity and the depth of a pixel, its position is moved to the time of the stamp, so that all
/// later steps see a global shutter.
class RollingShutter {
 public:
  /// All rows at once.
  RollingShutter() = default;
  /// `stamp`: the row that time stamps refer to. A readout of 0 is a global shutter.
  RollingShutter(const Rectification& rectification, double readout_s, StampRow stamp);

  bool is_global() const { return readout_s_ == 0.0; }
  /// Whether the readout can be estimated from the images: of a pair, not of a depth camera, whose depths have times of
  /// their own.
  bool can_be_measured() const { return rectification_.has_value() && !has_depth_map_; }
  void SetDepthMap() { has_depth_map_ = true; }
  /// Time from the first row of an image to the last.
  double readout_s() const { return readout_s_; }
  void SetReadout(double readout_s) { readout_s_ = readout_s; }

  /// Returns the shares of a rectified left pixel and its match; without a match (`disparity_px` <= 0), the right share
  /// is the left one.
  RowShares SharesOf(const Eigen::Vector2d& left_px, double disparity_px) const;

  /// Returns where (u, v, disparity) would be measured at the time of the stamp. `velocity` is that of the camera in
  /// its own frame, [m/s; rad/s]. Points nearer than the pair can see stay.
  Eigen::Vector3d Moved(const Eigen::Vector3d& uvd, const RowShares& shares, const Vector6d& velocity) const;

  /// The estimated state, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.readout_s_);
  }

 private:
  std::optional<Rectification> rectification_;
  StereoCamera camera_;
  double readout_s_ = 0.0;
  double stamp_share_ = 0.0;
  bool has_depth_map_ = false;
};

/// The features of a frame as measured, which are moved to the time of its stamp as the estimate of the velocity
/// improves.
class RollingFrame {
 public:
  RollingFrame(const RollingShutter& shutter, StereoFeatures measured);

  /// Sets the disparity by which a feature without depth is moved, here from its landmark; otherwise it is the median
  /// of the frame.
  void SetPointDisparity(size_t point, double disparity_px) { point_disparities_px_[point] = disparity_px; }
  void SetLineDisparities(size_t line, double p_px, double q_px) { line_disparities_px_[line] = {p_px, q_px}; }

  const StereoFeatures& measured() const { return measured_; }

  /// Returns the features at the time of the stamp. A moving camera bends the image of a straight edge into a parabola,
  /// to which the detector fitted a straight segment: its ends are moved to the straight edge.
  StereoFeatures MovedBy(const Vector6d& velocity) const;

 private:
  StereoLine Moved(size_t line, const Vector6d& velocity) const;

  RollingShutter shutter_;
  StereoFeatures measured_;
  std::vector<RowShares> point_shares_;
  /// At p, at q.
  std::vector<std::array<RowShares, 2>> line_shares_;
  std::vector<double> point_disparities_px_;
  std::vector<std::array<double, 2>> line_disparities_px_;
};

}  // namespace plslam::vo
