// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/motion/motion_estimator.h"
#include "core/motion/residual.h"

namespace plslam {

/// One image's view of a segment: the infinite line through the detected endpoints.
struct ObservedLine {
  Eigen::Vector2d start;
  /// Unit direction, and its unit normal; `length_px` is the distance of the endpoints.
  Eigen::Vector2d direction;
  Eigen::Vector2d normal;
  double length_px = 0.0;
};

/// A line ready for many linearisations: checked, and weighted as the options say.
struct PreparedLine {
  Segment3 segment_ref;
  /// Without what lies along the segment.
  Eigen::Matrix3d covariance_p;
  Eigen::Matrix3d covariance_q;
  ObservedLine left;
  ObservedLine right;
  double sigma_px;
  double sigma_disparity_p_px;
  double sigma_disparity_q_px;
  bool has_right;
  /// The paper's weights, or those described at `Linearize`.
  bool full_covariance;
};

/// nullopt for what cannot be used: anything not finite, segments without length, sigmas that are not positive, an
/// endpoint that is unknown. The right image is left out when a disparity is missing or its segment has no length.
std::optional<PreparedLine> Prepare(const LineCorrespondence& correspondence, const MotionOptions& options);

/// Distances in pixels of the projected endpoints p and q to the observed infinite lines: left p, left q, right p,
/// right q. False when an endpoint is behind the camera or too near.
///
/// The observed line is known where it was seen: each of its two ends has an independent error across the line, so
/// the distances of the two projected endpoints are correlated, and grow uncertain beyond the ends. The error of a
/// right end is that of the left end minus that of the disparity, as for points.
bool Linearize(const PreparedLine& line, const PoseView& view, double sigma_floor_px, Residual<4>& residual);

}  // namespace plslam
