// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"
#include "core/inertial/preintegration.h"
#include "core/optim/bundle/options.h"

namespace plslam {

/// A camera pose; fixed poses determine the gauge.
struct BundlePose {
  SE3 T_w_c;
  bool fixed = false;
};

struct BundlePoint {
  Eigen::Vector3d p_w = Eigen::Vector3d::Zero();
  bool fixed = false;
};

/// Only the infinite line is measured; the endpoints select a part of it.
struct BundleLine {
  Segment3 segment_w;
  bool fixed = false;
};

/// Observation of `point` from `pose` at (u, v, disparity); a negative disparity is not used.
struct PointObservation {
  int pose = -1;
  int point = -1;
  Eigen::Vector3d uvd = Eigen::Vector3d::Zero();
  double sigma_px = 1.0;
  double sigma_disparity_px = 1.0;
};

/// Observation of `line` from `pose` as a segment with disparities at its ends (negative: not used).
struct LineObservation {
  int pose = -1;
  int line = -1;
  Segment2 observed;
  double disparity_p_px = -1.0;
  double disparity_q_px = -1.0;
  double sigma_px = 1.0;
  double sigma_disparity_p_px = 1.0;
  double sigma_disparity_q_px = 1.0;
};

/// A measured motion T_a_b between two poses, with the covariance of its right perturbation.
struct RelativePose {
  int a = -1;
  int b = -1;
  SE3 T_a_b;
  Matrix6d covariance = Matrix6d::Identity();
};

/// Motion from pose a to pose b as an inertial sensor sensed it.
struct InertialMotion {
  int a = -1;
  int b = -1;
  SE3 T_c_imu;  ///< pose of the sensor in the camera
  Preintegration sensed;
  ImuBiasEstimate bias;  ///< before the adjustment
};

/// Gravity in the frame of the poses, and its covariance before the adjustment.
struct GravityPrior {
  Eigen::Vector3d g_w_m_s2 = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};

/// Poses, landmarks and all measurements. Indices refer to the vectors.
struct BundleProblem {
  StereoCamera camera;
  std::vector<BundlePose> poses;
  std::vector<BundlePoint> points;
  std::vector<BundleLine> lines;
  std::vector<PointObservation> point_observations;
  std::vector<LineObservation> line_observations;
  /// Only between poses with observations; those whose covariance is not positive definite are ignored. The covariances
  /// of the result do not include them.
  std::vector<RelativePose> relative_poses;
  /// Only between poses with observations; those of a sensor in order of time. The covariances of the result do not
  /// include them.
  std::vector<InertialMotion> inertial_motions;
  GravityPrior gravity;
};

/// Covariances of many poses take longer than their adjustment.
enum class BundleCovariances { kAll, kNone };

/// Root mean square residuals, normalised (standard deviations) and in pixels of the left image, over the final
/// inliers: of points, and of lines across (rms of the two ends).
struct BundleRms {
  double normalised = 0.0;
  double point_px = 0.0;
  double line_px = 0.0;
};

struct BundleResult {
  /// False if nothing could be adjusted (no free pose or landmark, no observations) or the solver failed; poses and
  /// landmarks are then as given, and `reason` says why. Never NaN.
  bool ok = false;
  std::string reason;
  std::vector<SE3> T_w_c;
  std::vector<Eigen::Vector3d> points;
  std::vector<Segment3> lines;
  /// Covariances of the right perturbation of each pose, given the fixed poses (zero for these; a kilometre and ten
  /// turns without observations, or if the information is singular); of positions and endpoints given all poses
  /// (conditional), for endpoints across the line only. Zero for landmarks that are fixed or have no inlier, which are
  /// as given. Empty if `ok` is false or none were requested.
  std::vector<Matrix6d> pose_covariances;
  std::vector<Eigen::Matrix3d> point_covariances;
  std::vector<Eigen::Matrix3d> line_p_covariances;
  std::vector<Eigen::Matrix3d> line_q_covariances;
  /// Final inliers, in the order of the observations. Never inliers: observations of landmarks behind a camera, and
  /// those that no longer determine their landmark once others are removed.
  std::vector<bool> point_inliers;
  std::vector<bool> line_inliers;
  BundleRms before;
  BundleRms after;
  int iterations = 0;
  bool stopped = false;
  /// At least one pass ended by itself. If none did, poses had not converged, and inliers are unreliable.
  bool converged = false;
};

/// Bundle adjustment of poses, points and lines (PL-SLAM §V.B): Levenberg-Marquardt with robust loss, landmarks
/// eliminated first (Schur complement: `SchurSolver`), outliers removed between passes. Minimises the sum of
/// rho(|r_i|^2) over whitened residual vectors r_i in both images, of points and lines side by side, with the
/// pseudo-Huber loss rho. One thread, so equal input gives equal output.
///
/// Invalid observations (not finite, sigmas not positive, segments without length) are never inliers. A landmark whose
/// observations do not determine a direction (one view without disparity, infinity) stays near its start in that
/// direction, and lines do not move along themselves. If nothing is fixed, the first pose is constant.
///
/// `stop`, if given, is read before each pass and between iterations: when it is set, the best state so far is
/// returned.
BundleResult AdjustBundle(const BundleProblem& problem, const BundleOptions& options,
                          const std::atomic<bool>* stop = nullptr,
                          BundleCovariances covariances = BundleCovariances::kAll);

}  // namespace plslam
