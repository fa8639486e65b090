// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"

namespace plslam {

/// Pose of a camera and derivative of its rotation by the parameters, shared by all residuals of one pose.
struct CameraView {
  Eigen::Matrix3d R_c_w = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_w_c = Eigen::Vector3d::Zero();
  /// Right Jacobian of the rotation parameters w: `Exp(w + dw)` is `Exp(w) Exp(turn * dw)` to first order.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();

  Eigen::Vector3d ToCamera(const Eigen::Vector3d& p_w) const { return R_c_w * (p_w - t_w_c); }
};

/// A pose parameterised by x = [a; w] relative to its start: `R = R_start Exp(w)`, `t_w_c = t_start + a`.
///
/// A plain vector space needs no manifold, whose product with each Jacobian costs as much as the Jacobian itself. The
/// derivative by a is minus that by a point in the map frame, so it costs nothing; rotations stay below half a turn.
class AdjustedPose {
 public:
  AdjustedPose() = default;
  /// `column_in`: index among the free poses, or -1.
  AdjustedPose(const SE3& T_w_c, int column_in) : start_(T_w_c), column(column_in) { Update(); }

  /// Recomputes `view` from `x`.
  void Update();
  /// Returns to the start pose.
  void Restore();
  SE3 T_w_c() const;
  /// Converts the covariance of `x` to that of the right perturbation of `T_w_c()`.
  Matrix6d RightCovariance(const Matrix6d& covariance_x) const;

 private:
  SE3 start_;

 public:
  bool IsFree() const { return column >= 0; }
  /// Free, and with observations.
  bool IsAdjusted() const { return IsFree() && observations > 0; }

  int column = -1;
  int observations = 0;
  /// At the end: whether an inlier or a relative pose determines it.
  bool constant = false;
  Vector6d x = Vector6d::Zero();
  CameraView view;
};

int CountFree(const std::vector<AdjustedPose>& poses);

/// Writes one row of a residual's Jacobian by a pose's [a; w], from the derivatives `g` by points `p_c` in the camera
/// frame. `by_world` is the derivative by a shift of the whole landmark in the map frame, `by_turn` the sum of g x p_c.
inline void WritePoseRow(const CameraView& view, const Eigen::RowVector3d& by_world,
                         const Eigen::RowVector3d& by_turn, double* row) {
  Eigen::Map<Eigen::RowVector3d>{row} = -by_world;
  Eigen::Map<Eigen::RowVector3d>{row + 3}.noalias() = by_turn * view.turn;
}

}  // namespace plslam
