// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/triangulation.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace plslam {

Eigen::Vector3d LineThrough(const Segment2& segment) {
  const Eigen::Vector2d direction = (segment.q - segment.p).normalized();
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  // Anchored at the middle, where rounding errors of the offset are smallest for segments far from the origin.
  const Eigen::Vector2d middle = 0.5 * (segment.p + segment.q);
  return {normal.x(), normal.y(), -normal.dot(middle)};
}

namespace {

constexpr double kMinLength_m = 1e-6;

Eigen::Matrix3d Symmetric(const Eigen::Matrix3d& m) { return 0.5 * (m + m.transpose()); }

bool IsFinite(const Gaussian3& g) { return g.mean.allFinite() && g.covariance.allFinite(); }

// Covariance of a backprojected endpoint whose image error is `sigma_px` across and `sigma_along_px` along
// `direction`.
Eigen::Matrix3d EndpointCovariance(const StereoCamera& camera, const Eigen::Vector3d& uvd,
                                   const Eigen::Vector2d& direction, double sigma_px, double sigma_along_px,
                                   double disparity_slope, double sigma_disparity_px) {
  const Eigen::Matrix3d J = camera.ProjectStereoJacobian(camera.Backproject(uvd)).inverse();
  // Sliding along the image segment changes the disparity, too, because the endpoint slides along the 3D segment.
  const Eigen::Vector3d along(direction.x(), direction.y(), disparity_slope);
  const Eigen::Vector3d across(-direction.y(), direction.x(), 0.0);
  Eigen::Matrix3d S =
      sigma_along_px * sigma_along_px * along * along.transpose() + sigma_px * sigma_px * across * across.transpose();
  S(2, 2) += sigma_disparity_px * sigma_disparity_px;
  return Symmetric(J * S * J.transpose());
}

// The position on a line nearest to `at`, with its covariance across; undetermined along the line.
struct LinePlace {
  Eigen::Vector3d position;
  Eigen::Matrix3d covariance;
};

LinePlace NearestOnLine(const UncertainSegment3& line, const Eigen::Vector3d& at) {
  const Eigen::Vector3d whole = line.segment.q - line.segment.p;
  const double s = (at - line.segment.p).dot(whole) / whole.squaredNorm();
  return {line.segment.p + s * whole, (1.0 - s) * (1.0 - s) * line.covariance_p + s * s * line.covariance_q};
}

// Kalman update of an endpoint by the two coordinates across the line.
Gaussian3 FuseAcross(const Gaussian3& endpoint, const LinePlace& place, const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 2, 3> across;
  across.row(0) = direction.unitOrthogonal();
  across.row(1) = direction.cross(Eigen::Vector3d(across.row(0)));
  const Eigen::Matrix2d innovation = across * (endpoint.covariance + place.covariance) * across.transpose();
  const Eigen::LDLT<Eigen::Matrix2d> factor(innovation);
  if (!(innovation.determinant() > 0.0) || !factor.isPositive()) return endpoint;
  const Eigen::Matrix<double, 3, 2> full_gain = factor.solve(across * endpoint.covariance).transpose();
  // The component of the gain along the line would move the endpoint. Joseph's form is valid for any gain.
  const Eigen::Matrix<double, 3, 2> gain = full_gain - direction * (direction.transpose() * full_gain);
  const Eigen::Matrix3d kept = Eigen::Matrix3d::Identity() - gain * across;
  const Eigen::Matrix2d seen = across * place.covariance * across.transpose();
  return {endpoint.mean + gain * (across * (place.position - endpoint.mean)),
          Symmetric(kept * endpoint.covariance * kept.transpose() + gain * seen * gain.transpose())};
}

}  // namespace

Gaussian3 TriangulatePoint(const StereoCamera& camera, const Eigen::Vector3d& uvd, double sigma_px,
                           double sigma_disparity_px) {
  return {camera.Backproject(uvd), camera.BackprojectCovariance(uvd, sigma_px, sigma_disparity_px)};
}

Segment3 BackprojectSegment(const StereoCamera& camera, const Segment2& left, double disparity_p_px,
                            double disparity_q_px) {
  return {camera.Backproject({left.p.x(), left.p.y(), disparity_p_px}),
          camera.Backproject({left.q.x(), left.q.y(), disparity_q_px})};
}

UncertainSegment3 TriangulateSegment(const StereoCamera& camera, const Segment2& left, double disparity_p_px,
                                     double disparity_q_px, double sigma_px, double sigma_along_px,
                                     double sigma_disparity_p_px, double sigma_disparity_q_px) {
  const double length = std::max(left.Length(), 1e-9);
  const Eigen::Vector2d direction = (left.q - left.p) / length;
  const double slope = (disparity_q_px - disparity_p_px) / length;
  UncertainSegment3 result;
  result.segment = BackprojectSegment(camera, left, disparity_p_px, disparity_q_px);
  result.covariance_p = EndpointCovariance(camera, {left.p.x(), left.p.y(), disparity_p_px}, direction, sigma_px,
                                           sigma_along_px, slope, sigma_disparity_p_px);
  result.covariance_q = EndpointCovariance(camera, {left.q.x(), left.q.y(), disparity_q_px}, direction, sigma_px,
                                           sigma_along_px, slope, sigma_disparity_q_px);
  return result;
}

double AngleToBaseline_rad(const Segment2& segment) {
  const Eigen::Vector2d d = segment.q - segment.p;
  return std::atan2(std::abs(d.y()), std::abs(d.x()));
}

double SegmentDisparitySigma_px(double angle_to_baseline_rad, double sigma_px) {
  const double sine = std::sin(angle_to_baseline_rad);
  if (!(sine > 0.0)) return std::numeric_limits<double>::infinity();
  return std::sqrt(2.0) * sigma_px / sine;
}

Gaussian3 Transform(const Eigen::Matrix3d& R_a_b, const Eigen::Vector3d& t_a_b, const Gaussian3& b) {
  return {R_a_b * b.mean + t_a_b, Symmetric(R_a_b * b.covariance * R_a_b.transpose())};
}

Gaussian3 FuseGaussian3(const Gaussian3& a, const Gaussian3& b) {
  if (!IsFinite(b)) return a;
  if (!IsFinite(a)) return b;
  const Eigen::Matrix3d sum = a.covariance + b.covariance;
  const Eigen::LDLT<Eigen::Matrix3d> factor(sum);
  const Eigen::Matrix3d gain = factor.solve(a.covariance).transpose();
  if (factor.info() != Eigen::Success || !factor.isPositive() || !gain.allFinite()) return a;
  const Eigen::Matrix3d kept = Eigen::Matrix3d::Identity() - gain;
  // Joseph's form keeps the result symmetric and positive.
  return {a.mean + gain * (b.mean - a.mean),
          Symmetric(kept * a.covariance * kept.transpose() + gain * b.covariance * gain.transpose())};
}

UncertainSegment3 FuseLine(const UncertainSegment3& segment, const UncertainSegment3& seen) {
  const Eigen::Vector3d whole = seen.segment.q - seen.segment.p;
  const bool usable = whole.allFinite() && whole.norm() > kMinLength_m && seen.covariance_p.allFinite() &&
                      seen.covariance_q.allFinite() && seen.segment.p.allFinite();
  if (!usable) return segment;
  const Eigen::Vector3d direction = whole.normalized();
  const Gaussian3 p =
      FuseAcross({segment.segment.p, segment.covariance_p}, NearestOnLine(seen, segment.segment.p), direction);
  const Gaussian3 q =
      FuseAcross({segment.segment.q, segment.covariance_q}, NearestOnLine(seen, segment.segment.q), direction);
  if (!IsFinite(p) || !IsFinite(q)) return segment;
  return {{p.mean, q.mean}, p.covariance, q.covariance};
}

}  // namespace plslam
