// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/point_cost.h"

#include <cmath>

#include "core/motion/residual.h"

namespace plslam {

PointCost::PointCost(const PointObservation& observation, const AdjustedPoint&, const CameraView&,
                     const StereoCamera& camera)
    : uvd_(observation.uvd.x() - camera.cx_px, observation.uvd.y() - camera.cy_px, observation.uvd.z()),
      weight_(1.0 / observation.sigma_px),
      weight_disparity_(1.0 / observation.sigma_disparity_px),
      f_px_(camera.f_px),
      focal_baseline_(camera.FocalBaseline()),
      min_depth_m_(camera.MinDepth()),
      rows_(observation.uvd.z() >= 0.0 ? 3 : 2) {}

bool PointCost::IsUsable(const PointObservation& observation) {
  const bool finite = observation.uvd.allFinite() && std::isfinite(observation.sigma_px);
  const bool disparity = observation.uvd.z() < 0.0 ||
                         (observation.sigma_disparity_px > 0.0 && std::isfinite(observation.sigma_disparity_px));
  return finite && observation.sigma_px > 0.0 && disparity;
}

bool PointCost::Evaluate(const CameraView& view, const double* p_w, double* residuals, double* by_pose,
                         double* by_landmark) const {
  const Eigen::Vector3d p_c = view.ToCamera(Eigen::Map<const Eigen::Vector3d>(p_w));
  if (!(p_c.z() > min_depth_m_)) return false;
  const double inverse_z = 1.0 / p_c.z();
  const double k = f_px_ * inverse_z;
  residuals[0] = weight_ * (uvd_.x() - k * p_c.x());
  residuals[1] = weight_ * (uvd_.y() - k * p_c.y());
  if (rows_ == 3) residuals[2] = weight_disparity_ * (uvd_.z() - focal_baseline_ * inverse_z);
  if (!by_pose && !by_landmark) return true;

  // Derivatives g of the residuals by the point in the camera: (a, 0, b), (0, a, c), (0, 0, d).
  const double a = -weight_ * k;
  const double b = -a * p_c.x() * inverse_z;
  const double c = -a * p_c.y() * inverse_z;
  const auto write_row = [&](int row, const Eigen::RowVector3d& by_world, const Eigen::RowVector3d& by_turn) {
    if (by_landmark) Eigen::Map<Eigen::RowVector3d>{by_landmark + 3 * row} = by_world;
    if (by_pose) WritePoseRow(view, by_world, by_turn, by_pose + 6 * row);
  };
  const auto& R = view.R_c_w;
  const double x = p_c.x();
  const double y = p_c.y();
  const double z = p_c.z();
  write_row(0, a * R.row(0) + b * R.row(2), {-b * y, b * x - a * z, a * y});
  write_row(1, a * R.row(1) + c * R.row(2), {a * z - c * y, c * x, -a * x});
  if (rows_ < 3) return true;
  const double d = weight_disparity_ * focal_baseline_ * inverse_z * inverse_z;
  write_row(2, d * R.row(2), {-d * y, d * x, 0.0});
  return true;
}

}  // namespace plslam
