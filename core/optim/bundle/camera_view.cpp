// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/camera_view.h"

#include <algorithm>
#include <cmath>

namespace plslam {
namespace {

Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& w) {
  const double angle2 = w.squaredNorm();
  const double angle = std::sqrt(angle2);
  const bool small = angle < 1e-4;
  const double b = small ? 0.5 - angle2 / 24.0 : (1.0 - std::cos(angle)) / angle2;
  const double c = small ? 1.0 / 6.0 - angle2 / 120.0 : (angle - std::sin(angle)) / (angle2 * angle);
  const Eigen::Matrix3d W = Skew(w);
  return Eigen::Matrix3d::Identity() - b * W + c * W * W;
}

}  // namespace

void AdjustedPose::Update() {
  const Eigen::Vector3d w = x.tail<3>();
  view.R_c_w = (start_.rotation() * ExpSO3(w)).toRotationMatrix().transpose();
  view.t_w_c = start_.translation() + x.head<3>();
  view.turn = RightJacobian(w);
}

void AdjustedPose::Restore() {
  x.setZero();
  Update();
}

SE3 AdjustedPose::T_w_c() const {
  // An unchanged pose is returned bit for bit.
  if (x.isZero(0.0)) return start_;
  return SE3(start_.rotation() * ExpSO3(x.tail<3>()), start_.translation() + x.head<3>());
}

Matrix6d AdjustedPose::RightCovariance(const Matrix6d& covariance_x) const {
  Matrix6d M = Matrix6d::Zero();
  M.topLeftCorner<3, 3>() = view.R_c_w;
  M.bottomRightCorner<3, 3>() = view.turn;
  const Matrix6d turned = M * covariance_x * M.transpose();
  return 0.5 * (turned + turned.transpose());
}

int CountFree(const std::vector<AdjustedPose>& poses) {
  const auto is_free = [](const AdjustedPose& pose) { return pose.IsFree(); };
  return static_cast<int>(std::count_if(poses.begin(), poses.end(), is_free));
}

}  // namespace plslam
