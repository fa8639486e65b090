// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "core/geometry/calibration.h"

namespace plslam {

/// A lens model by name, with the possible numbers of coefficients.
struct LensModel {
  std::string_view name;
  size_t min_coefficients;
  size_t max_coefficients;
  std::string_view coefficients;
};

/// Returns all models, in the order of messages to users.
std::span<const LensModel> LensModels();

/// Returns nullptr if there is none of that name.
const LensModel* FindLensModel(std::string_view name);

/// Returns "pinhole, radtan, ...".
std::string LensModelNames();

/// Whether a model of that name may have so many coefficients.
bool LensModelTakes(std::string_view name, size_t n_coefficients);

/// Lens distortion on the plane z = 1, with t = r^2 of the undistorted point:
/// * "pinhole": none.
/// * "radtan" (k1 k2 p1 p2 [k3]): Brown-Conrady as in OpenCV, radius r (1 + k1 t + k2 t^2 + k3 t^3), and tangential
///   terms.
/// * "rational" (k1 k2 p1 p2 k3 k4 k5 k6): the same, divided by 1 + k4 t + k5 t^2 + k6 t^3, as in OpenCV and ROS.
/// * "equidistant" (k1 k2 k3 k4): Kannala-Brandt as in Kalibr and OpenCV's fisheye, a polynomial of the angle.
/// * "double_sphere" (xi alpha): Usenko, Demmel and Cremers, "The Double Sphere Camera Model" (3DV 2018), eq. 40 to
///   42, at z = 1. Unlike the others it scales the image in its centre, by 1 / (1 + xi).
///
/// A lens model is only valid up to the angle where its radius stops growing; beyond, several rays share a pixel. The
/// functions return nothing there, nor if a denominator is not positive.
class Distortion {
 public:
  /// Throws std::runtime_error with one sentence for an unknown model or a wrong number of coefficients.
  explicit Distortion(const CameraCalibration& calibration);

  /// Returns distorted from undistorted coordinates; nullopt beyond `max_radius`.
  std::optional<Eigen::Vector2d> Distort(const Eigen::Vector2d& xy) const;
  /// The same, to the last bit, for many points in place (spans of one length), several times faster. NaN beyond
  /// `max_radius`.
  void Distort(std::span<double> x, std::span<double> y) const;

  /// Inverse of `Distort`, accurate to about 1e-12, by Newton's method; nullopt if no ray is projected there.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& distorted) const;

  /// Derivative of `Distort`.
  Eigen::Matrix2d Jacobian(const Eigen::Vector2d& xy) const;

  /// Largest undistorted radius (tangent of the angle from the axis) up to which the model is monotonic.
  double max_radius() const { return max_radius_; }

  bool IsIdentity() const;

  /// Scale of the centre of the image relative to no distortion: derivative of the distorted radius at 0.
  double CentreScale() const { return ProfileDerivative(0.0); }

 private:
  enum class Model { kPinhole, kRadtan, kRational, kEquidistant, kDoubleSphere };

  /// Distorted radius and its derivative by the model's own variable: the radius, or the angle for a fisheye.
  double Profile(double s) const;
  double ProfileDerivative(double s) const;
  /// Divisor of the radius: not 1 for the models "rational" and "double_sphere".
  double Denominator(double s) const;
  double MonotonicLimit(double end) const;
  double InvertProfile(double distorted_radius) const;
  Eigen::Vector2d Apply(const Eigen::Vector2d& xy) const;
  /// Divisor of the radial factor of "rational".
  double Divisor(double r2) const;
  /// Radial factor of "radtan" and "rational", and its derivative by r^2.
  double RadialFactor(double r2) const;
  double RadialFactorDerivative(double r2) const;
  Eigen::Vector2d Radtan(double x, double y, double r2, double radial) const;

  Model model_ = Model::kPinhole;
  // k: radial terms of s^3, s^5, s^7, s^9; p: tangential terms; divisor: k4 k5 k6 of "rational".
  double k_[4] = {0.0, 0.0, 0.0, 0.0};
  double p_[2] = {0.0, 0.0};
  double divisor_[3] = {0.0, 0.0, 0.0};
  double xi_ = 0.0;
  double alpha_ = 0.0;
  double max_profile_variable_ = 0.0;
  double max_radius_ = 0.0;
};

}  // namespace plslam
