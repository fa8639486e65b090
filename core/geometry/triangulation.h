// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"

namespace plslam {

/// A 3D line segment, given by its endpoints.
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

/// Returns the infinite line through a segment: [a, b, c] with a*u + b*v + c = 0 and a^2 + b^2 = 1, so that products
/// with homogeneous points are distances in pixels. The segment must have positive length.
Eigen::Vector3d LineThrough(const Segment2& segment);

/// Rotates the covariance of a vector from frame b to frame a.
inline Eigen::Matrix3d RotateCovariance(const Eigen::Matrix3d& R_a_b, const Eigen::Matrix3d& covariance_b) {
  return R_a_b * covariance_b * R_a_b.transpose();
}

/// A Gaussian distribution of a position.
struct Gaussian3 {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// A 3D segment with the covariances of its endpoints (assumed independent).
struct UncertainSegment3 {
  Segment3 segment;
  Eigen::Matrix3d covariance_p = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_q = Eigen::Matrix3d::Zero();
};

/// Returns the point of a stereo measurement (u, v, d), d > 0, in the left camera, to first order in the errors.
Gaussian3 TriangulatePoint(const StereoCamera& camera, const Eigen::Vector3d& uvd, double sigma_px,
                           double sigma_disparity_px);

/// Returns the 3D segment of a left segment with disparities (> 0) at its endpoints, in the left camera.
Segment3 BackprojectSegment(const StereoCamera& camera, const Segment2& left, double disparity_p_px,
                            double disparity_q_px);

/// The same with covariances. `sigma_px` is the sigma of an endpoint in the image across the segment; along it the
/// sigma is `sigma_along_px`, because detectors cut the same edge differently.
UncertainSegment3 TriangulateSegment(const StereoCamera& camera, const Segment2& left, double disparity_p_px,
                                     double disparity_q_px, double sigma_px, double sigma_along_px,
                                     double sigma_disparity_p_px, double sigma_disparity_q_px);

/// Returns the angle in the image between a segment and the baseline (the rows), 0 to pi/2. At small angles one pair
/// gives no depth: an error of e pixels across the segment becomes about e / sin(angle) in its disparity.
double AngleToBaseline_rad(const Segment2& segment);

/// Returns the sigma of the disparity on a segment at this angle if both images have `sigma_px` across it; infinity for
/// a parallel one.
double SegmentDisparitySigma_px(double angle_to_baseline_rad, double sigma_px);

/// Applies `T_a_b` (rotation and translation) to position and covariance.
Gaussian3 Transform(const Eigen::Matrix3d& R_a_b, const Eigen::Vector3d& t_a_b, const Gaussian3& b);

/// Returns the product of two independent Gaussians about the same position (information filter), in a form that never
/// inverts a single covariance, so zero (exactly known) and huge ones are safe. Returns `a` if `b` is not finite, and
/// vice versa; `a` if both are exactly known and disagree.
Gaussian3 FuseGaussian3(const Gaussian3& a, const Gaussian3& b);

/// Fuses a segment with another observation, perhaps cut differently: each endpoint of `segment` is updated only by the
/// infinite line of `seen`, across that line. Endpoints do not slide along it, and the extent stays that of `segment`.
/// Beyond the endpoints of `seen` the line is extrapolated, with growing uncertainty. Returns `segment` if `seen` is
/// not finite or has no length.
UncertainSegment3 FuseLine(const UncertainSegment3& segment, const UncertainSegment3& seen);

}  // namespace plslam
