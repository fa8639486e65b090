// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/line_residual.h"

#include "core/motion/residual.h"

namespace plslam {
namespace {

constexpr double kMinLength_px = 1.0;
constexpr double kMinLength_m = 1e-6;
// Independent share of noise: keeps the two distances of one image independent if a short segment projects onto one
// position of a long line.
constexpr double kIndependentShare = 0.1;

ObservedLine Observe(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  ObservedLine line;
  line.start = p;
  line.length_px = (q - p).norm();
  line.direction = (q - p) / std::max(line.length_px, 1e-12);
  line.normal = {-line.direction.y(), line.direction.x()};
  return line;
}

Eigen::Matrix3d AcrossOnly(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& direction) {
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
  return across * covariance * across;
}

// One endpoint in both images: its distances from the observed lines (rows `i` and `i + 2`), and its positions along
// them (0 to 1).
struct Projected {
  double along_left;
  double along_right;
};

Projected ProjectEndpoint(const PreparedLine& line, const Eigen::Matrix3d& covariance, const PoseView& view,
                          const Eigen::Vector3d& p_c, int i, Residual<4>& residual) {
  const double inverse_z = 1.0 / p_c.z();
  const double x = p_c.x() * inverse_z;
  const double y = p_c.y() * inverse_z;
  const double k = view.camera.f_px * inverse_z;
  const double u = view.camera.f_px * x + view.camera.cx_px;
  const double v = view.camera.f_px * y + view.camera.cy_px;
  const Eigen::Vector2d from_left = Eigen::Vector2d(u, v) - line.left.start;
  const Eigen::Vector2d from_right = Eigen::Vector2d(u - view.camera.baseline_m * k, v) - line.right.start;
  // Derivatives of the two distances by the point: the normals times those of the pixels, most of which are 0.
  const Eigen::Vector2d& left = line.left.normal;
  const Eigen::Vector2d& right = line.right.normal;
  const double x_right = x - view.camera.baseline_m * inverse_z;
  const Eigen::Vector3d g_left = k * Eigen::Vector3d(left.x(), left.y(), -(left.x() * x + left.y() * y));
  const Eigen::Vector3d g_right = k * Eigen::Vector3d(right.x(), right.y(), -(right.x() * x_right + right.y() * y));
  residual.r(i) = left.dot(from_left);
  residual.r(i + 2) = right.dot(from_right);
  residual.J.row(i) = PoseRow(g_left, p_c);
  residual.J.row(i + 2) = PoseRow(g_right, p_c);
  const Eigen::Vector3d ref_left = view.R.transpose() * g_left;
  const Eigen::Vector3d ref_right = view.R.transpose() * g_right;
  const Eigen::Vector3d covariance_left = covariance * ref_left;
  const double both = ref_right.dot(covariance_left);
  residual.S(i, i) += ref_left.dot(covariance_left);
  residual.S(i + 2, i) += both;
  residual.S(i, i + 2) += both;
  residual.S(i + 2, i + 2) += ref_right.dot(covariance * ref_right);
  return {line.left.direction.dot(from_left) / line.left.length_px,
          line.right.direction.dot(from_right) / std::max(line.right.length_px, kMinLength_px)};
}

// Adds errors across the observed line, propagated from its ends to the projected endpoints.
void AddMeasurementNoise(const PreparedLine& line, double sigma_floor_px, const Projected& p, const Projected& q,
                         Residual<4>& residual) {
  const double sigma = std::max(line.sigma_px, sigma_floor_px);
  const double sigma_dp = std::max(line.sigma_disparity_p_px, sigma_floor_px);
  const double sigma_dq = std::max(line.sigma_disparity_q_px, sigma_floor_px);
  const double own = line.full_covariance ? kIndependentShare * kIndependentShare : 1.0;
  const double tilt = line.right.normal.x();
  const Eigen::Vector4d independent(sigma * sigma, sigma * sigma, tilt * tilt * sigma_dp * sigma_dp + sigma * sigma,
                                    tilt * tilt * sigma_dq * sigma_dq + sigma * sigma);
  residual.S.diagonal() += own * independent;
  if (!line.full_covariance) return;
  // Columns: left end p, left end q, disparity p, disparity q, each in its standard deviation.
  const double shared = line.left.normal.dot(line.right.normal);
  Eigen::Matrix4d A;
  A << (1.0 - p.along_left) * sigma, p.along_left * sigma, 0.0, 0.0,  //
      (1.0 - q.along_left) * sigma, q.along_left * sigma, 0.0, 0.0,   //
      (1.0 - p.along_right) * shared * sigma, p.along_right * shared * sigma, (1.0 - p.along_right) * tilt * sigma_dp,
      p.along_right * tilt * sigma_dq,  //
      (1.0 - q.along_right) * shared * sigma, q.along_right * shared * sigma, (1.0 - q.along_right) * tilt * sigma_dp,
      q.along_right * tilt * sigma_dq;
  residual.S.noalias() += A * A.transpose();
}

void RemoveRightRows(Residual<4>& residual) {
  residual.r.tail<2>().setZero();
  residual.J.bottomRows<2>().setZero();
  residual.S.bottomRows<2>().setZero();
  residual.S.rightCols<2>().setZero();
  residual.S(2, 2) = 1.0;
  residual.S(3, 3) = 1.0;
}

}  // namespace

std::optional<PreparedLine> Prepare(const LineCorrespondence& o, const MotionOptions& options) {
  const bool finite = o.segment_ref.p.allFinite() && o.segment_ref.q.allFinite() && o.observed.p.allFinite() &&
                      o.observed.q.allFinite() && std::isfinite(o.disparity_p_px) && std::isfinite(o.disparity_q_px);
  if (!finite || !(o.sigma_px > 0.0) || !std::isfinite(o.sigma_px)) return std::nullopt;
  const Eigen::Vector3d segment = o.segment_ref.q - o.segment_ref.p;
  PreparedLine line;
  line.left = Observe(o.observed.p, o.observed.q);
  if (line.left.length_px < kMinLength_px || segment.norm() < kMinLength_m) return std::nullopt;
  if (!IsUsableCovariance(o.covariance_p, o.segment_ref.p) || !IsUsableCovariance(o.covariance_q, o.segment_ref.q)) {
    return std::nullopt;
  }
  line.segment_ref = o.segment_ref;
  line.full_covariance = options.landmark_covariance;
  const Eigen::Matrix3d nothing = Eigen::Matrix3d::Zero();
  line.covariance_p = line.full_covariance ? AcrossOnly(o.covariance_p, segment.normalized()) : nothing;
  line.covariance_q = line.full_covariance ? AcrossOnly(o.covariance_q, segment.normalized()) : nothing;
  line.sigma_px = o.sigma_px;
  line.sigma_disparity_p_px = o.sigma_disparity_p_px;
  line.sigma_disparity_q_px = o.sigma_disparity_q_px;
  line.right = Observe(o.observed.p - o.disparity_p_px * Eigen::Vector2d::UnitX(),
                       o.observed.q - o.disparity_q_px * Eigen::Vector2d::UnitX());
  const double smaller = std::min(o.sigma_disparity_p_px, o.sigma_disparity_q_px);
  line.has_right = o.disparity_p_px >= 0.0 && o.disparity_q_px >= 0.0 && line.right.length_px >= kMinLength_px &&
                   smaller > 0.0 && std::isfinite(o.sigma_disparity_p_px + o.sigma_disparity_q_px);
  return line;
}

bool Linearize(const PreparedLine& line, const PoseView& view, double sigma_floor_px, Residual<4>& residual) {
  const Eigen::Vector3d p_c = view.R * line.segment_ref.p + view.t;
  const Eigen::Vector3d q_c = view.R * line.segment_ref.q + view.t;
  if (!(p_c.z() > view.min_depth_m) || !(q_c.z() > view.min_depth_m)) return false;
  residual.S.setZero();
  const Projected p = ProjectEndpoint(line, line.covariance_p, view, p_c, 0, residual);
  const Projected q = ProjectEndpoint(line, line.covariance_q, view, q_c, 1, residual);
  AddMeasurementNoise(line, sigma_floor_px, p, q, residual);
  residual.dimension = line.has_right ? 4 : 2;
  if (!line.has_right) RemoveRightRows(residual);
  return true;
}

}  // namespace plslam
