// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/features/features.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"

namespace plslam::vo {

/// Effect on a stereo pair of taking the right image a little later (or earlier) than the left one while the camera
/// moves: the cameras of the pair are then separated by the baseline and by that motion. A left pixel at an unknown
/// depth appears in the right image at
///
///   (u_r, v_r) = project(T_late_c X - b e_x),   X = the point of the left pixel,
///
/// so the measured column determines the depth, and the depth determines the row.
class PairSkew {
 public:
  /// No skew: both images are taken at the same time.
  PairSkew() = default;
  /// `T_late_c` takes points from the left camera at the time of its image to the left camera at the time of the right
  /// image.
  PairSkew(const StereoCamera& camera, const SE3& T_late_c)
      : camera_(camera), R_late_c_(T_late_c.R()), t_late_c_(T_late_c.translation()), is_zero_(false) {}

  bool is_zero() const { return is_zero_; }

  /// Returns the row of the match in the right image minus that of the left pixel, for a measured column difference
  /// `measured_px` = u_left - u_right.
  double RowOffset_px(const Eigen::Vector2d& left_px, double measured_px) const {
    if (is_zero_) return 0.0;
    const Eigen::Vector3d ray = Ray(left_px);
    const double inverse_depth = InverseDepth(ray, left_px.x() - measured_px).value_or(0.0);
    return RowOffset_px(left_px, ray, std::max(inverse_depth, 0.0));
  }

  /// The same for a known depth, given as the disparity of a simultaneous pair.
  double RowOffsetAt_px(const Eigen::Vector2d& left_px, double disparity_px) const {
    return is_zero_ ? 0.0 : RowOffset_px(left_px, Ray(left_px), disparity_px / camera_.FocalBaseline());
  }

  /// Returns the measured column difference of a point with this disparity in a simultaneous pair.
  double Measured_px(const Eigen::Vector2d& left_px, double disparity_px) const {
    if (is_zero_) return disparity_px;
    const Eigen::Vector3d late = Ray(left_px) + disparity_px / camera_.FocalBaseline() * t_late_c_;
    if (!(late.z() > 0.0)) return disparity_px;
    return left_px.x() - (camera_.f_px * late.x() - disparity_px) / late.z() - camera_.cx_px;
  }

  /// Returns the disparity of a simultaneous pair, negative beyond infinity. Returns nullopt if the motion cancels the
  /// baseline, so that the pair has no depth.
  std::optional<double> Disparity_px(const Eigen::Vector2d& left_px, double measured_px) const {
    if (is_zero_) return measured_px;
    const std::optional<double> inverse_depth = InverseDepth(Ray(left_px), left_px.x() - measured_px);
    if (!inverse_depth) return std::nullopt;
    return camera_.FocalBaseline() * *inverse_depth;
  }

 private:
  /// Least share of the baseline, as seen along the ray, that must be left to measure a depth.
  static constexpr double kMinBaselineShare = 0.3;

  /// Direction of a left pixel in the late camera, for a point at depth 1.
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

/// Vertical disparity of a pair whose rectification is not perfect:
///
///   v_right - v_left = r0 + r1 x + r2 y + r3 x^2 + r4 x y + r5 y^2,   x = (u_right - cx) / half the width,
///                                                                     y = (v_left - cy) / half the height.
///
/// Residual errors of the rotation between the cameras, of a focal length or of a distortion have this form, as far as
/// they are smooth. Positions combine the column in the right image and the row in the left one, which a disparity
/// gives: u_left - disparity, v_left.
///
/// If the two images are not taken at the same time, the motion in between adds to the vertical disparity: this is the
/// `PairSkew` of the pair, which a field may contain.
class RowField {
 public:
  using Coefficients = Eigen::Matrix<double, 6, 1>;

  /// Residual rotation of the right camera, as far as rows show it: pitch moves pixels down, roll rotates them from
  /// right to down. A yaw mainly moves columns, and does not show in rows.
  struct Turn {
    double pitch_rad = 0.0;
    double roll_rad = 0.0;
  };

  /// Zero everywhere.
  RowField() = default;
  RowField(const StereoCamera& camera, const Coefficients& coefficients_px, const Turn& turn)
      : camera_(camera),
        coefficients_px_(coefficients_px),
        R_straight_turned_(ExpSO3({turn.pitch_rad, 0.0, -turn.roll_rad})),
        is_zero_(coefficients_px.isZero(0.0)) {}

  /// Returns the factors of the coefficients at a position.
  static Coefficients Terms(const StereoCamera& camera, const Eigen::Vector2d& place_px) {
    const double x = 2.0 * (place_px.x() - camera.cx_px) / camera.width_px;
    const double y = 2.0 * (place_px.y() - camera.cy_px) / camera.height_px;
    return {1.0, x, y, x * x, x * y, y * y};
  }

  /// Returns v_right - v_left at a position.
  double Offset_px(const Eigen::Vector2d& place_px) const {
    return is_zero_ ? 0.0 : Terms(camera_, place_px).dot(coefficients_px_);
  }

  /// Returns the field with the skew of a pair.
  RowField With(const PairSkew& skew) const {
    RowField field = *this;
    field.skew_ = skew;
    return field;
  }
  const PairSkew& skew() const { return skew_; }

  /// Returns v_right - v_left of the match of a left pixel with this column difference, from field and skew.
  double MatchOffset_px(const Eigen::Vector2d& left_px, double disparity_px) const {
    return Offset_px(left_px - Eigen::Vector2d(disparity_px, 0.0)) + skew_.RowOffset_px(left_px, disparity_px);
  }

  /// Returns the row in the left image of a pixel of the right one.
  double LeftRow_px(const Eigen::Vector2d& right_px) const {
    const double near_px = right_px.y() - Offset_px(right_px);
    return right_px.y() - Offset_px({right_px.x(), near_px});
  }

  /// Returns the error of the disparity at a position due to the rotation: roll moves columns as much as rows, pitch
  /// spreads or narrows them away from the middle row.
  double Disparity_px(const Eigen::Vector2d& place_px) const {
    if (is_zero_) return 0.0;
    const Eigen::Vector2d turned((place_px.x() - camera_.cx_px) / camera_.f_px,
                                 (place_px.y() + Offset_px(place_px) - camera_.cy_px) / camera_.f_px);
    const Eigen::Vector3d straight = R_straight_turned_ * turned.homogeneous();
    return camera_.f_px * (straight.x() / straight.z() - turned.x());
  }

  /// Returns the column difference to be measured for a disparity, from rotation and skew.
  double Measured_px(const Eigen::Vector2d& left_px, double disparity_px) const {
    const double turned_px = skew_.Measured_px(left_px, disparity_px);
    return turned_px + Disparity_px(left_px - Eigen::Vector2d(turned_px, 0.0));
  }

  /// Whether the field is zero everywhere; it may have a skew.
  bool is_zero() const { return is_zero_; }

 private:
  StereoCamera camera_;
  Coefficients coefficients_px_ = Coefficients::Zero();
  Eigen::Matrix3d R_straight_turned_ = Eigen::Matrix3d::Identity();
  bool is_zero_ = true;
  PairSkew skew_;
};

/// Subtracts `error_px(left_px, disparity_px)` from all disparities of both feature types; disparities that are then
/// not positive become unknown.
template <class Error>
void CorrectDisparities(StereoFeatures& features, const Error& error_px) {
  const auto correct = [&error_px](const Eigen::Vector2d& left_px, double& disparity_px) {
    disparity_px -= error_px(left_px, disparity_px);
    if (disparity_px <= 0.0) disparity_px = -1.0;
  };
  for (StereoPoint& point : features.points) {
    if (point.HasDepth()) correct(point.left.px, point.disparity_px);
  }
  for (StereoLine& line : features.lines) {
    if (!line.HasDepth()) continue;
    correct(line.left.segment.p, line.disparity_p_px);
    correct(line.left.segment.q, line.disparity_q_px);
  }
}

/// Removes the effect of the motion between the two images from measured disparities; if a pair then has no depth,
/// disparities become unknown.
inline void RemoveSkew(const PairSkew& skew, StereoFeatures& features) {
  if (skew.is_zero()) return;
  CorrectDisparities(features, [&skew](const Eigen::Vector2d& left_px, double disparity_px) {
    return disparity_px - skew.Disparity_px(left_px, disparity_px).value_or(0.0);
  });
}

}  // namespace plslam::vo
