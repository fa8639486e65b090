// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace plslam::synthetic {

/// A closed uniform cubic B-spline in the plane, walked by arc length; twice continuously differentiable.
class ClosedSpline {
 public:
  /// At least four control points, in order, without repeating the first.
  explicit ClosedSpline(std::vector<Eigen::Vector2d> control_points);

  double length() const { return lengths_.back(); }
  struct Pose {
    Eigen::Vector2d position;
    Eigen::Vector2d forward;  ///< unit tangent
  };
  /// `distance` in [0, length()].
  Pose At(double distance) const;

 private:
  struct Sample {
    Eigen::Vector2d position;
    Eigen::Vector2d derivative;
  };
  Sample Evaluate(double parameter) const;

  std::vector<Eigen::Vector2d> control_points_;
  /// Arc length at parameters 0, 1/kSteps, 2/kSteps, ... up to the number of control points.
  std::vector<double> lengths_;
};

/// Control points about `spacing_m` apart on a rectangle of the given half sides with rounded corners, anticlockwise
/// from the middle of the side at -y, heading +x.
std::vector<Eigen::Vector2d> RoundedRectangle(double half_x_m, double half_y_m, double radius_m, double spacing_m);

/// The control points about the origin, scaled so that the spline has this length.
std::vector<Eigen::Vector2d> ScaledToLength(const std::vector<Eigen::Vector2d>& control_points, double length_m);

}  // namespace plslam::synthetic
