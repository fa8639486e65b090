// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/line_endpoint_cost.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "core/motion/residual.h"

namespace plslam {
namespace {

// Limits the extrapolation from observations much shorter than the segment, so that weights stay finite.
constexpr double kMaxEndBeyond = 100.0;
// Standard deviation of the endpoints along the line, relative to its length.
constexpr double kAlongShare = 0.01;
// Independent error of a distance, relative to that of the observed ends.
constexpr double kDistanceOwnShare = 0.1;

}  // namespace

AdjustedEndpoints::AdjustedEndpoints(const BundleLine& line) : free(!line.fixed) {
  x << line.segment_w.p, line.segment_w.q;
  start = x;
}

bool AdjustedEndpoints::IsUsable() const {
  return start.allFinite() && (start.tail<3>() - start.head<3>()).norm() > kMinAdjusted_m;
}

Matrix6d AdjustedEndpoints::PriorWeight(double distance_m) const {
  const Eigen::Vector3d step = start.tail<3>() - start.head<3>();
  const Eigen::Matrix3d along = step * step.transpose() / step.squaredNorm();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along;
  const Eigen::Matrix3d weight = across / distance_m + along / (kAlongShare * step.norm());
  Matrix6d weights = Matrix6d::Zero();
  weights.topLeftCorner<3, 3>() = weight;
  weights.bottomRightCorner<3, 3>() = weight;
  return weights;
}

std::array<Eigen::Matrix3d, 2> AdjustedEndpoints::EndCovariances(const Matrix6d& covariance) const {
  const Across across = DirectionsAcross(Segment());
  const Eigen::Matrix3d project = across * across.transpose();
  return {project * covariance.topLeftCorner<3, 3>() * project,
          project * covariance.bottomRightCorner<3, 3>() * project};
}

LineEndpointCost::LineEndpointCost(const LineObservation& observation, const AdjustedEndpoints& line,
                                   const CameraView& view, const StereoCamera& camera)
    : start_px_(observation.observed.p - Eigen::Vector2d(camera.cx_px, camera.cy_px)),
      length_px_(observation.observed.Length()),
      sigma_px_(observation.sigma_px),
      sigma_disparity_p_px_(observation.sigma_disparity_p_px),
      sigma_disparity_q_px_(observation.sigma_disparity_q_px),
      min_depth_m_(camera.MinDepth()) {
  const ObservedImages images(observation, camera);
  left_ = images.left;
  right_ = images.right;
  rows_ = images.has_right ? 4 : 2;
  Anchor(view, line);
}

bool LineEndpointCost::IsUsable(const LineObservation& observation) { return LineCost::IsUsable(observation); }

void LineEndpointCost::Anchor(const CameraView& view, const AdjustedEndpoints& line) {
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
      const Eigen::Vector2d end_px = left_.f_px / ends[i].z() * ends[i].head<2>();
      along = std::clamp(direction.dot(end_px - start_px_) / length_px_, -kMaxEndBeyond, 1.0 + kMaxEndBeyond);
    }
    A(i, 0) = (1.0 - along) * sigma_px_;
    A(i, 1) = along * sigma_px_;
    A(i + 2, 0) = shared * A(i, 0);
    A(i + 2, 1) = shared * A(i, 1);
    A(i + 2, 2) = (1.0 - along) * tilt * sigma_disparity_p_px_;
    A(i + 2, 3) = along * tilt * sigma_disparity_q_px_;
  }
  Eigen::Matrix4d S = A * A.transpose();
  S.diagonal().array() += kDistanceOwnShare * kDistanceOwnShare * sigma_px_ * sigma_px_;
  whitening_ = S.llt().matrixL().solve(Eigen::Matrix4d::Identity());
}

bool LineEndpointCost::Evaluate(const CameraView& view, const double* x, double* residuals, double* by_pose,
                                double* by_landmark) const {
  const Eigen::Vector3d p = view.ToCamera(Eigen::Map<const Eigen::Vector3d>(x));
  const Eigen::Vector3d q = view.ToCamera(Eigen::Map<const Eigen::Vector3d>(x + 3));
  if (!(p.z() > min_depth_m_) || !(q.z() > min_depth_m_)) return false;
  // Row i concerns p if i is even, q if it is odd.
  Eigen::Vector4d r;
  Eigen::Vector3d g[4];
  for (int i = 0; i < rows_; ++i) r(i) = (i < 2 ? left_ : right_).Distance(i % 2 == 0 ? p : q, g[i]);
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
