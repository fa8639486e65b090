#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// By how many rows a place is lower in the right image of a pair than in the left, where the calibration that the pair was
/// rectified with is not quite right:
///
///   v_right - v_left = r0 + r1 x + r2 y + r3 x^2 + r4 x y + r5 y^2,   x = (u_right - cx) / cx,   y = (v_left - cy) / cy,
///
/// with x and y in -1..1 over the image. What is left of a rotation between the cameras, of a focal length or of a
/// distortion is of this shape, as far as it is smooth. Places are told by the column in the right image and the row in the
/// left one, as a disparity tells them: u_left - disparity, v_left.
class RowField {
 public:
  using Coefficients = Eigen::Matrix<double, 6, 1>;

  /// Zero everywhere.
  RowField() = default;
  RowField(const StereoCamera& camera, const Coefficients& coefficients_px)
      : center_px_(camera.cx_px, camera.cy_px),
        f_px_(camera.f_px),
        coefficients_px_(coefficients_px),
        R_straight_turned_(ExpSO3({coefficients_px(0) / camera.f_px, 0.0, -coefficients_px(1) / camera.cx_px})),
        is_zero_(coefficients_px.isZero(0.0)) {}

  /// What the coefficients are multiplied by at a place.
  static Coefficients Terms(const StereoCamera& camera, const Eigen::Vector2d& place_px) {
    return TermsAt(Eigen::Vector2d(camera.cx_px, camera.cy_px), place_px);
  }

  /// v_right - v_left at a place.
  double Offset_px(const Eigen::Vector2d& place_px) const {
    return is_zero_ ? 0.0 : TermsAt(center_px_, place_px).dot(coefficients_px_);
  }

  /// The row in the left image of a pixel of the right one.
  double LeftRow_px(const Eigen::Vector2d& right_px) const {
    const double near_px = right_px.y() - Offset_px(right_px);
    return right_px.y() - Offset_px({right_px.x(), near_px});
  }

  /// What the turn of the right camera that the rows show adds to the disparity at a place: a roll (r1) moves columns as much
  /// as rows, a pitch (r0) spreads or narrows them away from the middle row. A yaw moves columns above all, of which rows tell
  /// nothing.
  double Disparity_px(const Eigen::Vector2d& place_px) const {
    if (is_zero_) return 0.0;
    const Eigen::Vector2d right_px(place_px.x(), place_px.y() + Offset_px(place_px));
    const Eigen::Vector2d turned = (right_px - center_px_) / f_px_;
    const Eigen::Vector3d straight = R_straight_turned_ * turned.homogeneous();
    return f_px_ * (straight.x() / straight.z() - turned.x());
  }

  /// Everywhere, so that nothing is to be done.
  bool is_zero() const { return is_zero_; }

 private:
  static Coefficients TermsAt(const Eigen::Vector2d& center_px, const Eigen::Vector2d& place_px) {
    const Eigen::Vector2d at = (place_px - center_px).cwiseQuotient(center_px);
    return {1.0, at.x(), at.y(), at.x() * at.x(), at.x() * at.y(), at.y() * at.y()};
  }

  Eigen::Vector2d center_px_ = Eigen::Vector2d::Ones();
  double f_px_ = 1.0;
  Coefficients coefficients_px_ = Coefficients::Zero();
  Eigen::Matrix3d R_straight_turned_ = Eigen::Matrix3d::Identity();
  bool is_zero_ = true;
};

}  // namespace plslam
