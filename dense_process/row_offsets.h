// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"

namespace plslam::dense {

/// Standard deviation of a normal distribution, by the median of its absolute values.
inline constexpr double kSigmaOfMedian = 1.4826;

/// Vertical disparity of a pair whose rectification is not perfect, as the features of a keyframe show it: how much
/// lower their partners are in the right image. A matcher of rows loses its matches where rows are off by a pixel.
struct RowOffsets {
  /// v_right - v_left = terms * coefficients, with terms 1, x, y, x^2, x y, y^2 of the position from the principal
  /// point in half image sizes, as in self-calibration (vo_process/stereo/row_field.h). Zero: not significant.
  Eigen::Matrix<double, 6, 1> coefficients_px = Eigen::Matrix<double, 6, 1>::Zero();
  /// Root mean square over the features, and its standard deviation.
  double size_px = 0.0;
  double sigma_px = 0.0;

  bool is_zero() const { return coefficients_px.isZero(0.0); }
  double At(const StereoCamera& camera, double u_px, double v_px) const;
};

/// Estimates the offsets of an image from its points whose rows were measured, without outliers. Zero with too few of
/// them, and below a quarter of a pixel: matches do not suffer from it.
RowOffsets EstimateRows(const StereoFeatures& features, const StereoCamera& camera);

/// Returns the right image with its rows where they belong.
cv::Mat StraightenRows(const cv::Mat& right, const RowOffsets& rows, const StereoCamera& camera);

}  // namespace plslam::dense
