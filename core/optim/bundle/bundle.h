// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"
#include "core/optim/bundle/options.h"

namespace plslam {

/// A camera of the adjustment; fixed ones hold the others in place.
struct BundlePose {
  SE3 T_w_c;
  bool fixed = false;
};

struct BundlePoint {
  Eigen::Vector3d p_w = Eigen::Vector3d::Zero();
  bool fixed = false;
};

/// Only the infinite line is measured; endpoints say which part of it is meant.
struct BundleLine {
  Segment3 segment_w;
  bool fixed = false;
};

/// `pose` sees `point` at (u, v, disparity); a disparity below zero is not used.
struct PointObservation {
  int pose = -1;
  int point = -1;
  Eigen::Vector3d uvd = Eigen::Vector3d::Zero();
  double sigma_px = 1.0;
  double sigma_disparity_px = 1.0;
};

/// `pose` sees `line` as a segment with disparities at its ends (below zero: not used).
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

/// What is known of the motion between two poses, T_a_b, with the covariance of its right perturbation.
struct RelativePose {
  int a = -1;
  int b = -1;
  SE3 T_a_b;
  Matrix6d covariance = Matrix6d::Identity();
};

/// Poses and landmarks with everything that ties them together. Indices are places in the vectors.
struct BundleProblem {
  StereoCamera camera;
  std::vector<BundlePose> poses;
  std::vector<BundlePoint> points;
  std::vector<BundleLine> lines;
  std::vector<PointObservation> point_observations;
  std::vector<LineObservation> line_observations;
  /// Only between poses that see something; those whose covariance is not positive definite do not count. The
  /// covariances of the result leave them out.
  std::vector<RelativePose> relative_poses;
};

/// Those of many poses take longer than their adjustment.
enum class BundleCovariances { kAll, kNone };

/// Normalised (standard deviations) and in pixels of the left image, over the observations that are inliers in the
/// end: of points, and of lines across (the rms of the two ends).
struct BundleRms {
  double normalised = 0.0;
  double point_px = 0.0;
  double line_px = 0.0;
};

struct BundleResult {
  /// False where nothing could be adjusted (no free pose or landmark, nothing seen) or the solver failed; poses and
  /// landmarks are then as given, and `reason` says why. Never a NaN.
  bool ok = false;
  std::string reason;
  std::vector<SE3> T_w_c;
  std::vector<Eigen::Vector3d> points;
  std::vector<Segment3> lines;
  /// Of the right perturbation of each pose, given the fixed poses (zero for those; a kilometre and ten turns where
  /// nothing is seen, or the whole cannot be inverted); of positions and endpoints given all poses (conditional),
  /// across the line only for endpoints. Zero for landmarks that are fixed or have no inlier, which are as given.
  /// Empty where `ok` is false or none were asked for.
  std::vector<Matrix6d> pose_covariances;
  std::vector<Eigen::Matrix3d> point_covariances;
  std::vector<Eigen::Matrix3d> line_p_covariances;
  std::vector<Eigen::Matrix3d> line_q_covariances;
  /// In the order of the observations: those that agree in the end. Observations of landmarks behind a camera never
  /// do, nor do those that do not determine their landmark any more once others are gone.
  std::vector<bool> point_inliers;
  std::vector<bool> line_inliers;
  BundleRms before;
  BundleRms after;
  int iterations = 0;
  bool stopped = false;
  /// A pass came to its end: where none did, poses were on their way, and inliers say little.
  bool converged = false;
};

/// Bundle adjustment of poses, points and lines (PL-SLAM §V.B): Levenberg-Marquardt with robust loss, landmarks
/// eliminated first (Schur complement: `SchurSolver`), outliers removed between passes.
/// Residuals are whitened vectors in both images; points and lines stand side by side. One thread, so equal input
/// gives equal output.
///
/// What cannot be measured (not finite, sigmas that are not positive, segments without length) is never an inlier. A
/// landmark whose observations leave a direction open (one view without disparity, infinity) stays near where it was
/// given in that direction, and lines stay where they are along themselves. Where nothing is fixed the first pose is
/// constant.
///
/// `stop`, if given, is looked at before each pass and between iterations: when it is set, the best state so far is
/// returned.
BundleResult AdjustBundle(const BundleProblem& problem, const BundleOptions& options,
                          const std::atomic<bool>* stop = nullptr,
                          BundleCovariances covariances = BundleCovariances::kAll);

}  // namespace plslam
