#include "core/optim/line_endpoint_cost.h"

#include <Eigen/Cholesky>

#include "core/motion/residual.h"
#include "core/optim/line_cost.h"

namespace plslam {
namespace {

constexpr double kMinLength_px = 1.0;
constexpr double kMinLength_m = 1e-6;
// A distance's own error, as share of that of the observed ends.
constexpr double kOwnShare = 0.1;

}  // namespace

AdjustedEndpoints::AdjustedEndpoints(const BundleLine& line) : free(!line.fixed) {
  x << line.segment_w.p, line.segment_w.q;
  start = x;
}

bool AdjustedEndpoints::IsUsable() const {
  return start.allFinite() && (start.tail<3>() - start.head<3>()).norm() > kMinLength_m;
}

std::array<Eigen::Matrix3d, 2> AdjustedEndpoints::EndCovariances(const Matrix6d& covariance) const {
  const Across across = DirectionsAcross(Segment());
  const Eigen::Matrix3d project = across * across.transpose();
  return {project * covariance.topLeftCorner<3, 3>() * project,
          project * covariance.bottomRightCorner<3, 3>() * project};
}

LineEndpointCost::Image::Image(const Eigen::Vector2d& p_px, const Eigen::Vector2d& q_px, double baseline_m_in)
    : start_px(p_px), baseline_m(baseline_m_in) {
  const Eigen::Vector2d direction = (q_px - p_px).normalized();
  normal = {-direction.y(), direction.x()};
}

LineEndpointCost::LineEndpointCost(const LineSight& sight, const AdjustedEndpoints& line, const CameraView& view,
                                   const StereoCamera& camera)
    : f_px_(camera.f_px), min_depth_m_(PoseView::MinDepth(camera)) {
  const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
  const Eigen::Vector2d p = sight.observed.p - centre;
  const Eigen::Vector2d q = sight.observed.q - centre;
  const Eigen::Vector2d p_right = p - sight.disparity_p_px * Eigen::Vector2d::UnitX();
  const Eigen::Vector2d q_right = q - sight.disparity_q_px * Eigen::Vector2d::UnitX();
  const bool has_right =
      sight.disparity_p_px >= 0.0 && sight.disparity_q_px >= 0.0 && (q_right - p_right).norm() >= kMinLength_px;
  rows_ = has_right ? 4 : 2;
  left_ = Image(p, q, 0.0);
  if (has_right) right_ = Image(p_right, q_right, camera.baseline_m);
  Weigh(sight, line, view);
}

bool LineEndpointCost::IsUsable(const LineSight& sight) { return LineCost::IsUsable(sight); }

void LineEndpointCost::Weigh(const LineSight& sight, const AdjustedEndpoints& line, const CameraView& view) {
  const double tilt = rows_ == 4 ? right_.normal.x() : 0.0;
  const double shared = rows_ == 4 ? left_.normal.dot(right_.normal) : 0.0;
  const Eigen::Vector2d direction(left_.normal.y(), -left_.normal.x());
  const Segment3 segment = line.Segment();
  const Eigen::Vector3d ends[] = {view.ToCamera(segment.p), view.ToCamera(segment.q)};
  // Columns: errors of left p, left q, disparity p, disparity q. Rows as those of the residual.
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 2; ++i) {
    double along = i;
    if (ends[i].z() > min_depth_m_) {
      const Eigen::Vector2d end_px = f_px_ / ends[i].z() * ends[i].head<2>();
      along = direction.dot(end_px - left_.start_px) / sight.observed.Length();
    }
    A(i, 0) = (1.0 - along) * sight.sigma_px;
    A(i, 1) = along * sight.sigma_px;
    A(i + 2, 0) = shared * A(i, 0);
    A(i + 2, 1) = shared * A(i, 1);
    A(i + 2, 2) = (1.0 - along) * tilt * sight.sigma_disparity_p_px;
    A(i + 2, 3) = along * tilt * sight.sigma_disparity_q_px;
  }
  Eigen::Matrix4d S = A * A.transpose();
  S.diagonal().array() += kOwnShare * kOwnShare * sight.sigma_px * sight.sigma_px;
  whitening_ = S.llt().matrixL().solve(Eigen::Matrix4d::Identity());
}

double LineEndpointCost::Distance(const Image& image, const Eigen::Vector3d& p_c, Eigen::Vector3d& by_p_c) const {
  const double k = f_px_ / p_c.z();
  const Eigen::Vector2d px(k * (p_c.x() - image.baseline_m), k * p_c.y());
  by_p_c << k * image.normal, -image.normal.dot(px) / p_c.z();
  return image.normal.dot(px - image.start_px);
}

bool LineEndpointCost::Evaluate(const CameraView& view, const double* x, double* residuals, double* by_pose,
                                double* by_landmark) const {
  const Eigen::Vector3d p = view.ToCamera(Eigen::Map<const Eigen::Vector3d>(x));
  const Eigen::Vector3d q = view.ToCamera(Eigen::Map<const Eigen::Vector3d>(x + 3));
  if (!(p.z() > min_depth_m_) || !(q.z() > min_depth_m_)) return false;
  // Row i is by p where i is even, by q where it is odd.
  Eigen::Vector4d r;
  Eigen::Vector3d g[4];
  for (int i = 0; i < rows_; ++i) r(i) = Distance(i < 2 ? left_ : right_, i % 2 == 0 ? p : q, g[i]);
  for (int i = 0; i < rows_; ++i) {
    residuals[i] = 0.0;
    Eigen::Vector3d g_p = Eigen::Vector3d::Zero();
    Eigen::Vector3d g_q = Eigen::Vector3d::Zero();
    for (int j = 0; j <= i; ++j) {
      residuals[i] += whitening_(i, j) * r(j);
      (j % 2 == 0 ? g_p : g_q) += whitening_(i, j) * g[j];
    }
    const Eigen::RowVector3d world_p = g_p.transpose() * view.R_c_w;
    const Eigen::RowVector3d world_q = g_q.transpose() * view.R_c_w;
    if (by_landmark) {
      Eigen::Map<Eigen::RowVector3d>{by_landmark + 6 * i} = world_p;
      Eigen::Map<Eigen::RowVector3d>{by_landmark + 6 * i + 3} = world_q;
    }
    if (by_pose) WritePoseRow(view, world_p + world_q, (g_p.cross(p) + g_q.cross(q)).transpose(), by_pose + 6 * i);
  }
  return true;
}

}  // namespace plslam
