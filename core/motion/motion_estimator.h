// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"
#include "core/motion/options.h"

namespace plslam {

/// A 3D point of the reference frame and where the current stereo frame sees it.
struct PointCorrespondence {
  /// In the reference frame; covariance of that position, same frame.
  Eigen::Vector3d p_ref = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// (u, v, disparity); a negative disparity is not used.
  Eigen::Vector3d uvd = Eigen::Vector3d::Zero();
  double sigma_px = 1.0;
  double sigma_disparity_px = 1.0;
};

/// A 3D segment of the reference frame and the detected segment it is matched with. Residuals are the distances of
/// the projected 3D endpoints to the infinite detected line, in the left and, by the disparities, in the right image.
struct LineCorrespondence {
  Segment3 segment_ref;
  /// Covariances of the endpoints in the reference frame. What lies along the segment is free and must not count.
  Eigen::Matrix3d covariance_p = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_q = Eigen::Matrix3d::Zero();
  Segment2 observed;
  /// Disparities at the observed endpoints; negative ones are not used.
  double disparity_p_px = -1.0;
  double disparity_q_px = -1.0;
  double sigma_px = 1.0;
  double sigma_disparity_p_px = 1.0;
  double sigma_disparity_q_px = 1.0;
};

/// Gaussian knowledge of the motion before looking: covariance of the right perturbation, as in `SE3`.
struct MotionPrior {
  SE3 T_cur_ref;
  Matrix6d covariance = Matrix6d::Identity();
};

struct MotionEstimate {
  /// Takes points of the reference frame to the current camera.
  SE3 T_cur_ref;
  /// Inverse Hessian of the last iteration (PL-SLAM §IV.C), of the right perturbation of T_cur_ref^-1 (that is, of
  /// T_ref_cur * Exp(x), x in the current camera), scaled so that it is honest (NEES about 6).
  Matrix6d covariance = Matrix6d::Zero();
  /// In the order of the correspondences.
  std::vector<bool> point_inliers;
  std::vector<bool> line_inliers;
  int n_point_inliers = 0;
  int n_line_inliers = 0;
  int iterations = 0;
  /// Root mean square of the normalised inlier residuals (about 1 when the sigmas are honest).
  double rms = 0.0;
  /// Typical residual of each feature type in its own sigmas: the root of the median squared norm over what is
  /// expected of it (1 when the sigmas are honest), of all correspondences; 0 where there are none.
  double point_deviation = 0.0;
  double line_deviation = 0.0;
};

/// Robust two-step Gauss-Newton over points and lines (PL-SLAM §IV.C): pseudo-Huber on all, outliers removed by
/// chi-square with a floored robust scale, then inliers alone. `initial` starts the iteration and is no measurement;
/// `prior`, if given, is one.
///
/// Returns nullopt when the motion is not determined: too few inliers, no convergence, a Hessian that is singular
/// (all lines parallel, say) and no prior to fill it. Never returns a NaN.
std::optional<MotionEstimate> EstimateMotion(const std::vector<PointCorrespondence>& points,
                                             const std::vector<LineCorrespondence>& lines, const StereoCamera& camera,
                                             const SE3& initial, const std::optional<MotionPrior>& prior,
                                             const MotionOptions& options);

}  // namespace plslam
