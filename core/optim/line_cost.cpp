#include "core/optim/line_cost.h"

#include <cmath>

#include "core/motion/residual.h"

namespace plslam {
namespace {

constexpr double kMinLength_px = 1.0;
constexpr double kMinLength_m = 1e-6;
// A right end's own error across the line, as share of the left one's.
constexpr double kOwnShare = 0.1;
// Squared sine of the angle between endpoints below which a line goes through the camera centre.
constexpr double kMinSine2 = 1e-12;

Eigen::Vector2d NormalOf(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  const Eigen::Vector2d direction = (q - p).normalized();
  return {-direction.y(), direction.x()};
}

// Distance in pixels of the ray `x` to the line with plane normal `m`, and its derivative by m.
double Distance(const Eigen::Vector3d& m, const Eigen::Vector3d& x, double f_px, Eigen::Vector3d& by_m) {
  const double inverse = 1.0 / std::sqrt(m.x() * m.x() + m.y() * m.y());
  const double distance = f_px * m.dot(x) * inverse;
  by_m = (f_px * inverse) * x;
  const double k = distance * inverse * inverse;
  by_m.x() -= k * m.x();
  by_m.y() -= k * m.y();
  return distance;
}

}  // namespace

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
         (start_segment.q - start_segment.p).norm() > kMinLength_m;
}

Segment3 AdjustedLine::At(const double* parameters) const {
  return {start_segment.p + across * Eigen::Map<const Eigen::Vector2d>(parameters),
          start_segment.q + across * Eigen::Map<const Eigen::Vector2d>(parameters + 2)};
}

std::array<Eigen::Matrix3d, 2> AdjustedLine::EndCovariances(const Eigen::Matrix4d& covariance) const {
  return {across * covariance.topLeftCorner<2, 2>() * across.transpose(),
          across * covariance.bottomRightCorner<2, 2>() * across.transpose()};
}

LineCost::LineCost(const LineSight& sight, const AdjustedLine& line, const CameraView&, const StereoCamera& camera)
    : line_(&line),
      weight_(1.0 / sight.sigma_px),
      f_px_(camera.f_px),
      baseline_m_(camera.baseline_m),
      min_depth_m_(PoseView::MinDepth(camera)) {
  const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
  const Eigen::Vector2d p = sight.observed.p;
  const Eigen::Vector2d q = sight.observed.q;
  const Eigen::Vector2d p_right = p - sight.disparity_p_px * Eigen::Vector2d::UnitX();
  const Eigen::Vector2d q_right = q - sight.disparity_q_px * Eigen::Vector2d::UnitX();
  has_right_ =
      sight.disparity_p_px >= 0.0 && sight.disparity_q_px >= 0.0 && (q_right - p_right).norm() >= kMinLength_px;
  const Eigen::Vector2d normal_right = has_right_ ? NormalOf(p_right, q_right) : Eigen::Vector2d::Zero();
  shared_ = NormalOf(p, q).dot(normal_right);
  const auto ray = [&](const Eigen::Vector2d& px) { return ((px - centre) / f_px_).homogeneous().eval(); };
  const auto weight_right = [&](double sigma_disparity_px) {
    return 1.0 / std::hypot(normal_right.x() * sigma_disparity_px, kOwnShare * sight.sigma_px);
  };
  ends_[0] = {ray(p), ray(p_right), weight_right(sight.sigma_disparity_p_px)};
  ends_[1] = {ray(q), ray(q_right), weight_right(sight.sigma_disparity_q_px)};
}

bool LineCost::IsUsable(const LineSight& s) {
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
  const Eigen::Vector3d p = view.ToCamera(segment_w.p);
  const Eigen::Vector3d q = view.ToCamera(segment_w.q);
  if (!(p.z() > min_depth_m_) && !(q.z() > min_depth_m_)) return false;
  // Normals of the planes through the segment and the left and right centre; the right one is at (baseline, 0, 0).
  const Eigen::Vector3d d = q - p;
  const Eigen::Vector3d m = p.cross(q);
  const Eigen::Vector3d m_right = m + baseline_m_ * Eigen::Vector3d(0.0, d.z(), -d.y());
  const double smallest = kMinSine2 * p.squaredNorm() * q.squaredNorm();
  if (!(m.head<2>().squaredNorm() > smallest) || !(m_right.head<2>().squaredNorm() > smallest)) return false;

  const auto write_row = [&](int i, const Eigen::Vector3d& by_m, const Eigen::Vector3d& by_d) {
    const Eigen::Vector3d g_p = q.cross(by_m) - by_d;
    const Eigen::Vector3d g_q = by_m.cross(p) + by_d;
    const Eigen::RowVector3d world_p = g_p.transpose() * view.R_c_w;
    const Eigen::RowVector3d world_q = g_q.transpose() * view.R_c_w;
    if (by_landmark) {
      Eigen::Map<Eigen::RowVector2d>{by_landmark + 4 * i}.noalias() = world_p * line_->across;
      Eigen::Map<Eigen::RowVector2d>{by_landmark + 4 * i + 2}.noalias() = world_q * line_->across;
    }
    if (by_pose) WritePoseRow(view, world_p + world_q, (g_p.cross(p) + g_q.cross(q)).transpose(), by_pose + 6 * i);
  };
  const bool jacobians = by_pose || by_landmark;
  int row = 0;
  for (const End& end : ends_) {
    Eigen::Vector3d by_m;
    const double left = Distance(m, end.left, f_px_, by_m);
    residuals[row] = weight_ * left;
    if (jacobians) write_row(row, weight_ * by_m, Eigen::Vector3d::Zero());
    ++row;
    if (!has_right_) continue;
    Eigen::Vector3d by_m_right;
    const double right = Distance(m_right, end.right, f_px_, by_m_right);
    residuals[row] = end.weight_right * (right - shared_ * left);
    if (jacobians) {
      const Eigen::Vector3d by_d = baseline_m_ * Eigen::Vector3d(0.0, -by_m_right.z(), by_m_right.y());
      write_row(row, end.weight_right * (by_m_right - shared_ * by_m), end.weight_right * by_d);
    }
    ++row;
  }
  return true;
}

bool LineCost::Plausible(const CameraView& view, const double* x) const {
  const Segment3 segment_w = line_->At(x);
  const Eigen::Vector3d p = view.ToCamera(segment_w.p);
  const Eigen::Vector3d d = view.R_c_w * (segment_w.q - segment_w.p);
  for (const End& end : ends_) {
    // The place of the line that is nearest to the ray: n is across both.
    const Eigen::Vector3d n = end.left.cross(d);
    const double depth = p.cross(d).dot(n) / n.squaredNorm();
    if (!(depth > min_depth_m_)) return false;
  }
  return true;
}

}  // namespace plslam
