// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/motion/motion_estimator.h"
#include "core/motion/residual.h"

namespace plslam {

/// The infinite line through the detected endpoints of a segment in one image.
struct ObservedLine {
  Eigen::Vector2d start;
  /// Unit direction, and its unit normal; `length_px` is the distance of the endpoints.
  Eigen::Vector2d direction;
  Eigen::Vector2d normal;
  double length_px = 0.0;
};

/// A validated line, weighted according to the options, for repeated linearisation.
struct PreparedLine {
  Segment3 segment_ref;
  /// Covariances across the segment only.
  Eigen::Matrix3d covariance_p;
  Eigen::Matrix3d covariance_q;
  ObservedLine left;
  ObservedLine right;
  double sigma_px;
  double sigma_disparity_p_px;
  double sigma_disparity_q_px;
  bool has_right;
  /// Whether the covariance described at `Linearize` is used instead of the paper's weights.
  bool full_covariance;
};

/// Returns nullopt for an invalid correspondence: values that are not finite, segments without length, sigmas that are
/// not positive, an undetermined endpoint. The right image is omitted if a disparity is missing or its segment has no
/// length.
std::optional<PreparedLine> Prepare(const LineCorrespondence& correspondence, const MotionOptions& options);

/// Computes the distances in pixels of the projected endpoints p and q from the observed infinite lines: left p, left
/// q, right p, right q. Returns false if an endpoint is behind the camera or too near.
///
/// The observed line is determined by its two ends, each with an independent error across the line, so the distances of
/// the two projected endpoints are correlated, and less certain beyond the ends. The error of a right end is that of
/// the left end minus that of the disparity, as for points.
bool Linearize(const PreparedLine& line, const PoseView& view, double sigma_floor_px, Residual<4>& residual);

}  // namespace plslam
