// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/optim/bundle/bundle.h"
#include "core/optim/bundle/camera_view.h"

namespace plslam {

/// A point with its position in the map frame as parameters.
struct AdjustedPoint {
  static constexpr int kSize = 3;
  static constexpr bool kAlwaysPrior = false;
  using Parameters = Eigen::Vector3d;

  explicit AdjustedPoint(const BundlePoint& point) : x(point.p_w), start(point.p_w), free(!point.fixed) {}

  bool IsUsable() const { return start.allFinite(); }
  Eigen::Vector3d Middle() const { return x; }
  /// Square root of the information of a weak prior.
  Eigen::Matrix3d PriorWeight(double distance_m) const { return Eigen::Matrix3d::Identity() / distance_m; }

  Parameters x;
  Parameters start;
  bool free;
};

/// One observation of a point: whitened residuals (u, v, disparity), or (u, v) without disparity; measured minus
/// predicted. The disparity is the contribution of the right image.
class PointCost {
 public:
  using Landmark = AdjustedPoint;
  static constexpr int kMaxRows = 3;
  /// Derivatives by the landmark are minus those by a shift of the camera.
  static constexpr bool kShiftsAgainstCamera = true;

  PointCost() = default;
  PointCost(const PointObservation& observation, const AdjustedPoint& point, const CameraView& view,
            const StereoCamera& camera);

  /// False for invalid observations: not finite, or sigmas not positive.
  static bool IsUsable(const PointObservation& observation);

  /// Updates nothing: points have no state between passes.
  void Anchor(const CameraView&, const AdjustedPoint&) {}

  int rows() const { return rows_; }

  /// Computes residuals at the position `p_w` of the point and, for non-null pointers, their Jacobians (row-major,
  /// `rows()` x 6 and `rows()` x 3). Returns false and writes nothing if the point is behind the camera or too near.
  bool Evaluate(const CameraView& view, const double* p_w, double* residuals, double* by_pose,
                double* by_landmark) const;

  /// Squared distance in the left image, in px^2, from whitened residuals.
  double SquaredPixels(const double* residuals) const {
    return (residuals[0] * residuals[0] + residuals[1] * residuals[1]) / (weight_ * weight_);
  }

 private:
  Eigen::Vector3d uvd_;
  double weight_;
  double weight_disparity_;
  double f_px_;
  double focal_baseline_;
  double min_depth_m_;
  int rows_;
};

}  // namespace plslam
