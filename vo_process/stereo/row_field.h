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

/// By how many rows a place is lower in the right image of a pair than in the left, where the calibration that the
/// pair was rectified with is not quite right:
///
///   v_right - v_left = r0 + r1 x + r2 y + r3 x^2 + r4 x y + r5 y^2,   x = (u_right - cx) / half the width,
///                                                                     y = (v_left - cy) / half the height.
///
/// What is left of a rotation between the cameras, of a focal length or of a distortion is of this shape, as far as
/// it is smooth. Places are told by the column in the right image and the row in the left one, as a disparity tells
/// them: u_left - disparity, v_left.
///
/// Where the two images are not taken at the same time, rows differ by what the camera moves in between, too: that is
/// the `PairSkew` of the pair, which may come with the field.
class RowField {
 public:
  using Coefficients = Eigen::Matrix<double, 6, 1>;

  /// By how much the right camera is turned against what the calibration says, as far as rows show it: pitch moves
  /// pixels down, roll turns them from right to down. A yaw moves columns above all, of which rows tell nothing.
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

  /// What the coefficients are multiplied by at a place.
  static Coefficients Terms(const StereoCamera& camera, const Eigen::Vector2d& place_px) {
    const double x = 2.0 * (place_px.x() - camera.cx_px) / camera.width_px;
    const double y = 2.0 * (place_px.y() - camera.cy_px) / camera.height_px;
    return {1.0, x, y, x * x, x * y, y * y};
  }

  /// v_right - v_left at a place.
  double Offset_px(const Eigen::Vector2d& place_px) const {
    return is_zero_ ? 0.0 : Terms(camera_, place_px).dot(coefficients_px_);
  }

  /// The same of a pair with a skew.
  RowField With(const PairSkew& skew) const {
    RowField field = *this;
    field.skew_ = skew;
    return field;
  }
  const PairSkew& skew() const { return skew_; }

  /// v_right - v_left of the match of a left pixel, whose column tells this disparity: of field and skew.
  double MatchOffset_px(const Eigen::Vector2d& left_px, double disparity_px) const {
    return Offset_px(left_px - Eigen::Vector2d(disparity_px, 0.0)) + skew_.RowOffset_px(left_px, disparity_px);
  }

  /// The row in the left image of a pixel of the right one.
  double LeftRow_px(const Eigen::Vector2d& right_px) const {
    const double near_px = right_px.y() - Offset_px(right_px);
    return right_px.y() - Offset_px({right_px.x(), near_px});
  }

  /// What the turn adds to the disparity at a place: roll moves columns as much as rows, pitch spreads or narrows
  /// them away from the middle row.
  double Disparity_px(const Eigen::Vector2d& place_px) const {
    if (is_zero_) return 0.0;
    const Eigen::Vector2d turned((place_px.x() - camera_.cx_px) / camera_.f_px,
                                 (place_px.y() + Offset_px(place_px) - camera_.cy_px) / camera_.f_px);
    const Eigen::Vector3d straight = R_straight_turned_ * turned.homogeneous();
    return camera_.f_px * (straight.x() / straight.z() - turned.x());
  }

  /// The field is, everywhere, so that nothing is to be done; it may have a skew.
  bool is_zero() const { return is_zero_; }

 private:
  StereoCamera camera_;
  Coefficients coefficients_px_ = Coefficients::Zero();
  Eigen::Matrix3d R_straight_turned_ = Eigen::Matrix3d::Identity();
  bool is_zero_ = true;
  PairSkew skew_;
};

/// Subtracts `error_px(left_px, disparity_px)` from all disparities of both feature types; those that would fall to
/// zero lose their depth.
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

/// From measured disparities, what the camera moved between the two images; where the pair then tells no depth, there
/// is none.
inline void TakeSkewAway(const PairSkew& skew, StereoFeatures& features) {
  if (skew.is_zero()) return;
  CorrectDisparities(features, [&skew](const Eigen::Vector2d& left_px, double disparity_px) {
    return disparity_px - skew.Disparity_px(left_px, disparity_px).value_or(0.0);
  });
}

}  // namespace plslam::vo
