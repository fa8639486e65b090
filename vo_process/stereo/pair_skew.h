// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>

#include <Eigen/Core>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// What it does to a stereo pair that the right image is taken a little later (or earlier) than the left one, while
/// the camera moves: the pair is then one of two cameras that are apart by the baseline and by that motion. Depth and
/// motion together say where a left pixel is found in the right image:
///
///   (u_r, v_r) = project(T_late_c X - b e_x),   X = the point of the left pixel at an unknown depth,
///
/// so a measured column tells the depth, and the depth tells the row.
class PairSkew {
 public:
  /// None: both are taken at the same time.
  PairSkew() = default;
  /// `T_late_c` takes points from the left camera as it took its image to the left camera when the right image was
  /// taken.
  PairSkew(const StereoCamera& camera, const SE3& T_late_c)
      : camera_(camera), R_late_c_(T_late_c.R()), t_late_c_(T_late_c.translation()), is_zero_(false) {}

  bool is_zero() const { return is_zero_; }

  /// By how many rows the match of a left pixel is lower in the right image, where the column tells `measured_px` =
  /// u_left - u_right.
  double RowOffset_px(const Eigen::Vector2d& left_px, double measured_px) const {
    if (is_zero_) return 0.0;
    const Eigen::Vector3d ray = Ray(left_px);
    const double inverse_depth = InverseDepth(ray, left_px.x() - measured_px).value_or(0.0);
    return RowOffset_px(left_px, ray, std::max(inverse_depth, 0.0));
  }

  /// The same where the depth is known, by the disparity that a pair taken at one time would have.
  double RowOffsetAt_px(const Eigen::Vector2d& left_px, double disparity_px) const {
    return is_zero_ ? 0.0 : RowOffset_px(left_px, Ray(left_px), disparity_px / camera_.FocalBaseline());
  }

  /// The disparity that a pair taken at one time would have. nullopt where the motion has taken the baseline away, so
  /// that the pair tells no depth, and negative beyond infinity.
  std::optional<double> Disparity_px(const Eigen::Vector2d& left_px, double measured_px) const {
    if (is_zero_) return measured_px;
    const std::optional<double> inverse_depth = InverseDepth(Ray(left_px), left_px.x() - measured_px);
    if (!inverse_depth) return std::nullopt;
    return camera_.FocalBaseline() * *inverse_depth;
  }

 private:
  /// Of the baseline that is left, seen along the ray, the least that tells a depth.
  static constexpr double kMinBaselineShare = 0.3;

  /// Direction of a left pixel as the late camera sees it, for a point at depth 1.
  Eigen::Vector3d Ray(const Eigen::Vector2d& left_px) const {
    return R_late_c_ * Eigen::Vector3d((left_px.x() - camera_.cx_px) / camera_.f_px,
                                       (left_px.y() - camera_.cy_px) / camera_.f_px, 1.0);
  }

  double RowOffset_px(const Eigen::Vector2d& left_px, const Eigen::Vector3d& ray, double inverse_depth) const {
    const Eigen::Vector3d late = ray + inverse_depth * t_late_c_;
    return late.z() > 0.0 ? camera_.f_px * late.y() / late.z() + camera_.cy_px - left_px.y() : 0.0;
  }

  std::optional<double> InverseDepth(const Eigen::Vector3d& ray, double right_u_px) const {
    const double x = (right_u_px - camera_.cx_px) / camera_.f_px;
    const double baseline_m = camera_.baseline_m - t_late_c_.x() + x * t_late_c_.z();
    if (!(baseline_m > kMinBaselineShare * camera_.baseline_m)) return std::nullopt;
    return (ray.x() - x * ray.z()) / baseline_m;
  }

  StereoCamera camera_;
  Eigen::Matrix3d R_late_c_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_late_c_ = Eigen::Vector3d::Zero();
  bool is_zero_ = true;
};

}  // namespace plslam
