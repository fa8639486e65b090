// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/stereo/pair_skew.h"

namespace plslam {

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

}  // namespace plslam
