// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"

namespace plslam::rectify_check {

/// The same point in the two rectified images of a pair.
struct RowMatch {
  Eigen::Vector2d left_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d right_px = Eigen::Vector2d::Zero();

  /// Vertical disparity, which rectification should make zero: how much lower the point is in the right image.
  double RowError() const { return right_px.y() - left_px.y(); }
  double Disparity() const { return left_px.x() - right_px.x(); }
};

/// Points that look alike in both images at any position: unlike the tracker's matching, this one does not assume equal
/// rows. Mutual best, with a ratio to the second best, and at most a tenth of the height apart in rows, which keeps
/// most chance matches out.
std::vector<RowMatch> MatchAcrossRows(const ImageFeatures& left, const ImageFeatures& right, int height_px);

/// Agreement of the rows. Row errors are fitted, robustly, by offset + roll * x + scale * y with x, y from the
/// principal point, in focal lengths: the effects of a wrong pitch, a wrong roll, and different focal lengths.
struct RowErrors {
  int matches = 0;
  double median_px = 0.0;  ///< with its sign
  double median_abs_px = 0.0;
  double p95_abs_px = 0.0;
  double offset_px = 0.0;
  double roll_deg = 0.0;
  double scale_percent = 0.0;
  double f_px = 0.0;
  /// Share of the matches that would be behind the camera (left and right are exchanged if it is most of them).
  double behind = 0.0;
};

/// All zero for fewer than 3 matches.
RowErrors MeasureRows(const std::vector<RowMatch>& matches, const StereoCamera& camera);

/// Verdict on the calibration.
struct RowVerdict {
  bool usable = false;
  std::string sentence;
};

RowVerdict CheckRows(const RowErrors& errors);

}  // namespace plslam::rectify_check
