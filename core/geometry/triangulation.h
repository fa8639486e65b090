// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"

namespace plslam {

/// A 3D line segment by its endpoints.
struct Segment3 {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
};

/// A line segment in an image, in pixels. Directed: the brighter side is on its right (as seen in the image).
struct Segment2 {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Eigen::Vector2d q = Eigen::Vector2d::Zero();

  double Length() const { return (q - p).norm(); }
};

/// Infinite line through a segment: [a, b, c] with a*u + b*v + c = 0 and a^2 + b^2 = 1, so that products with
/// homogeneous points are distances in pixels. The segment must have positive length.
Eigen::Vector3d LineThrough(const Segment2& segment);

/// Covariance in a of a vector whose covariance in b is known.
inline Eigen::Matrix3d RotateCovariance(const Eigen::Matrix3d& R_a_b, const Eigen::Matrix3d& covariance_b) {
  return R_a_b * covariance_b * R_a_b.transpose();
}

/// A Gaussian over positions.
struct Gaussian3 {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// A 3D segment with the covariances of its endpoints (taken as independent of each other).
struct UncertainSegment3 {
  Segment3 segment;
  Eigen::Matrix3d covariance_p = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_q = Eigen::Matrix3d::Zero();
};

/// Point of a stereo measurement (u, v, d), d > 0, in the left camera, to first order in the errors.
Gaussian3 TriangulatePoint(const StereoCamera& camera, const Eigen::Vector3d& uvd, double sigma_px,
                           double sigma_disparity_px);

/// Segment of the left image with disparities (> 0) at its endpoints, in the left camera.
Segment3 BackprojectSegment(const StereoCamera& camera, const Segment2& left, double disparity_p_px,
                            double disparity_q_px);

/// The same with covariances. `sigma_px` is the sigma of an endpoint in the image across the segment; along it
/// the endpoint slides by `sigma_along_px`, as detectors cut the same edge at different places.
UncertainSegment3 TriangulateSegment(const StereoCamera& camera, const Segment2& left, double disparity_p_px,
                                     double disparity_q_px, double sigma_px, double sigma_along_px,
                                     double sigma_disparity_p_px, double sigma_disparity_q_px);

/// Angle of a segment in the image against the baseline (the rows), 0 to pi/2. Small angles have no depth from one
/// pair: an error of e pixels across the segment is one of about e / sin(angle) in its disparity.
double AngleToBaseline_rad(const Segment2& segment);

/// Sigma of the disparity on a segment at this angle when both images see it with `sigma_px` across; infinity for
/// a parallel one.
double SegmentDisparitySigma_px(double angle_to_baseline_rad, double sigma_px);

/// `T_a_b` (rotation and translation given apart) applied to position and covariance.
Gaussian3 Transform(const Eigen::Matrix3d& R_a_b, const Eigen::Vector3d& t_a_b, const Gaussian3& b);

/// Product of two independent Gaussians about the same position (information filter), in the form that never inverts
/// a single covariance, so zero (exactly known) and huge ones are safe. Returns `a` unchanged where `b` is not
/// finite, and the other way round; where both are exactly known and disagree, `a`.
Gaussian3 FuseGaussian3(const Gaussian3& a, const Gaussian3& b);

/// A segment seen again, perhaps cut elsewhere: each endpoint of `segment` learns only what the infinite line of
/// `seen` says, across that line. Endpoints never slide along it, and the extent stays that of `segment`. Where
/// endpoints of `segment` lie beyond those of `seen`, the line is extrapolated with the uncertainty this brings.
/// Unchanged where `seen` is not finite or has no length.
UncertainSegment3 FuseLine(const UncertainSegment3& segment, const UncertainSegment3& seen);

}  // namespace plslam
