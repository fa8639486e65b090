// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"
#include "core/motion/options.h"

namespace plslam {

/// A 3D point of the reference frame and its measurement in the current stereo frame.
struct PointCorrespondence {
  /// Position in the reference frame, and its covariance there.
  Eigen::Vector3d p_ref = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// (u, v, disparity); a negative disparity is not used.
  Eigen::Vector3d uvd = Eigen::Vector3d::Zero();
  double sigma_px = 1.0;
  double sigma_disparity_px = 1.0;
};

/// A 3D segment of the reference frame and the detected segment that it is matched with. Residuals are the distances of
/// the projected 3D endpoints from the infinite detected line, in the left and, by the disparities, in the right image.
struct LineCorrespondence {
  Segment3 segment_ref;
  /// Covariances of the endpoints in the reference frame. Components along the segment are undetermined and ignored.
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

/// Gaussian prior of the motion: covariance of the right perturbation, as in `SE3`.
struct MotionPrior {
  SE3 T_cur_ref;
  Matrix6d covariance = Matrix6d::Identity();
};

struct MotionEstimate {
  /// Takes points of the reference frame to the current camera.
  SE3 T_cur_ref;
  /// Inverse Hessian of the last iteration (PL-SLAM §IV.C), of the right perturbation of T_cur_ref^-1 (that is, of
  /// T_ref_cur * Exp(x), x in the current camera), scaled to be consistent (NEES about 6).
  Matrix6d covariance = Matrix6d::Zero();
  /// In the order of the correspondences.
  std::vector<bool> point_inliers;
  std::vector<bool> line_inliers;
  int n_point_inliers = 0;
  int n_line_inliers = 0;
  int iterations = 0;
  /// Root mean square of the normalised inlier residuals (about 1 for correct sigmas).
  double rms = 0.0;
  /// Typical residual of each feature type in units of its sigmas: the root of the median squared norm over its
  /// expectation (1 for correct sigmas), over all correspondences; 0 if there are none.
  double point_deviation = 0.0;
  double line_deviation = 0.0;
};

/// Robust two-step Gauss-Newton over points and lines (PL-SLAM §IV.C): pseudo-Huber on all, outliers removed by
/// chi-square with a robust scale that has a floor, then inliers alone. `initial` is the start of the iteration, not a
/// measurement; `prior`, if given, is one.
///
/// Returns nullopt if the motion is not determined: too few inliers, no convergence, or a singular Hessian (as with
/// parallel lines only) without a prior. Never returns NaN.
std::optional<MotionEstimate> EstimateMotion(const std::vector<PointCorrespondence>& points,
                                             const std::vector<LineCorrespondence>& lines, const StereoCamera& camera,
                                             const SE3& initial, const std::optional<MotionPrior>& prior,
                                             const MotionOptions& options);

}  // namespace plslam
