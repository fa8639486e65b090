// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/line_cost.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/hypot.h"
#include "core/motion/residual.h"

namespace plslam {
namespace {

constexpr double kMinLength_px = 1.0;
// Independent error of a right end across the line, relative to the left one's.
constexpr double kRightOwnShare = 0.1;
// Largest extension of the observed part beyond the segment, in lengths of it.
constexpr double kMaxSeenBeyond = 0.5;

// Parameter along the segment (0: p, 1: q) at which the line is nearest to the ray; NaN if they are parallel.
double AlongAt(const Eigen::Vector3d& ray, const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  const Eigen::Vector3d n = ray.cross(q - p);
  return p.cross(ray).dot(n) / n.squaredNorm();
}

}  // namespace

ObservedImage::ObservedImage(const Eigen::Vector2d& p_px, const Eigen::Vector2d& q_px, double f_px_in,
                             double baseline_m_in)
    : f_px(f_px_in), baseline_m(baseline_m_in) {
  const Eigen::Vector2d direction = (q_px - p_px).normalized();
  normal = {-direction.y(), direction.x()};
  offset_px = normal.dot(0.5 * (p_px + q_px));
}

ObservedImages::ObservedImages(const LineObservation& observation, const StereoCamera& camera) {
  const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
  const Eigen::Vector2d p = observation.observed.p - centre;
  const Eigen::Vector2d q = observation.observed.q - centre;
  left = ObservedImage(p, q, camera.f_px, 0.0);
  const Eigen::Vector2d p_right = p - observation.disparity_p_px * Eigen::Vector2d::UnitX();
  const Eigen::Vector2d q_right = q - observation.disparity_q_px * Eigen::Vector2d::UnitX();
  has_right = observation.disparity_p_px >= 0.0 && observation.disparity_q_px >= 0.0 &&
              (q_right - p_right).norm() >= kMinLength_px;
  if (has_right) right = ObservedImage(p_right, q_right, camera.f_px, camera.baseline_m);
}

Across DirectionsAcross(const Segment3& segment) {
  const Eigen::Vector3d direction = (segment.q - segment.p).normalized();
  Across across;
  across.col(0) = direction.unitOrthogonal();
  across.col(1) = direction.cross(across.col(0));
  return across;
}

AdjustedLine::AdjustedLine(const BundleLine& line)
    : start_segment(line.segment_w), across(Across::Zero()), free(!line.fixed) {
  if (IsUsable()) across = DirectionsAcross(start_segment);
}

bool AdjustedLine::IsUsable() const {
  return start_segment.p.allFinite() && start_segment.q.allFinite() &&
         (start_segment.q - start_segment.p).norm() > kMinAdjusted_m;
}

Segment3 AdjustedLine::At(const double* parameters) const {
  return {start_segment.p + across * Eigen::Map<const Eigen::Vector2d>(parameters),
          start_segment.q + across * Eigen::Map<const Eigen::Vector2d>(parameters + 2)};
}

std::array<Eigen::Matrix3d, 2> AdjustedLine::EndCovariances(const Eigen::Matrix4d& covariance) const {
  return {across * covariance.topLeftCorner<2, 2>() * across.transpose(),
          across * covariance.bottomRightCorner<2, 2>() * across.transpose()};
}

LineCost::LineCost(const LineObservation& observation, const AdjustedLine& line, const CameraView& view,
                   const StereoCamera& camera)
    : line_(&line), weight_(1.0 / observation.sigma_px), min_depth_m_(camera.MinDepth()) {
  const ObservedImages images(observation, camera);
  left_ = images.left;
  right_ = images.right;
  has_right_ = images.has_right;
  shared_ = left_.normal.dot(right_.normal);
  const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
  const auto end = [&](const Eigen::Vector2d& px, double sigma_disparity_px) {
    return End{0.0, ((px - centre) / camera.f_px).homogeneous(),
               1.0 / Hypot(right_.normal.x() * sigma_disparity_px, kRightOwnShare * observation.sigma_px)};
  };
  ends_ = {end(observation.observed.p, observation.sigma_disparity_p_px),
           end(observation.observed.q, observation.sigma_disparity_q_px)};
  Anchor(view, line);
}

void LineCost::Anchor(const CameraView& view, const AdjustedLine& line) {
  const Segment3 segment_w = line.Segment();
  const Eigen::Vector3d p = view.ToCamera(segment_w.p);
  const Eigen::Vector3d q = view.ToCamera(segment_w.q);
  for (End& end : ends_) end.along = std::clamp(AlongAt(end.ray, p, q), -kMaxSeenBeyond, 1.0 + kMaxSeenBeyond);
}

bool LineCost::IsUsable(const LineObservation& s) {
  const bool finite = s.observed.p.allFinite() && s.observed.q.allFinite() && std::isfinite(s.disparity_p_px) &&
                      std::isfinite(s.disparity_q_px) && std::isfinite(s.sigma_px);
  if (!finite || !(s.sigma_px > 0.0) || !(s.observed.Length() >= kMinLength_px)) return false;
  if (s.disparity_p_px < 0.0 || s.disparity_q_px < 0.0) return true;
  return s.sigma_disparity_p_px > 0.0 && s.sigma_disparity_q_px > 0.0 &&
         std::isfinite(s.sigma_disparity_p_px + s.sigma_disparity_q_px);
}

bool LineCost::Evaluate(const CameraView& view, const double* x, double* residuals, double* by_pose,
                        double* by_landmark) const {
  const Segment3 segment_w = line_->At(x);
  const Eigen::Vector3d p_c = view.ToCamera(segment_w.p);
  const Eigen::Vector3d step_c = view.R_c_w * (segment_w.q - segment_w.p);
  std::array<Eigen::Vector3d, 2> places;
  for (int i = 0; i < 2; ++i) {
    places[i] = p_c + ends_[i].along * step_c;
    if (!(places[i].z() > min_depth_m_)) return false;
  }
  int row = 0;
  const auto write_row = [&](const End& end, const Eigen::Vector3d& place_c, const Eigen::Vector3d& g) {
    if (!by_landmark && !by_pose) return;
    const Eigen::RowVector3d by_world = g.transpose() * view.R_c_w;
    if (by_landmark) {
      const Eigen::RowVector2d by_across = by_world * line_->across;
      Eigen::Map<Eigen::RowVector4d>{by_landmark + 4 * row} << (1.0 - end.along) * by_across, end.along * by_across;
    }
    if (by_pose) WritePoseRow(view, by_world, g.cross(place_c).transpose(), by_pose + 6 * row);
  };
  for (int i = 0; i < 2; ++i) {
    Eigen::Vector3d g_left;
    const double left = left_.Distance(places[i], g_left);
    residuals[row] = weight_ * left;
    write_row(ends_[i], places[i], weight_ * g_left);
    ++row;
    if (!has_right_) continue;
    Eigen::Vector3d g_right;
    const double weight = ends_[i].weight_right;
    residuals[row] = weight * (right_.Distance(places[i], g_right) - shared_ * left);
    write_row(ends_[i], places[i], weight * (g_right - shared_ * g_left));
    ++row;
  }
  return true;
}

}  // namespace plslam
