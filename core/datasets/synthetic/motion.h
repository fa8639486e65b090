// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/se3.h"

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

/// Pose of the left camera at each frame, in the world's frame w. Fractional frames exist for motion blur.
class Motion {
 public:
  virtual ~Motion() = default;
  /// T_w_c; `frame` in [0, size() - 1].
  virtual SE3 At(double frame) const = 0;
};

/// How a built-in world is walked through.
struct Walk {
  std::vector<Eigen::Vector2d> control_points;  ///< of a closed spline
  double height_m = 0.0;
  double speed = 0.0;       ///< m/s, default
  double sway = 1.0;        ///< scale of the sideways and vertical motion
  double turn = 1.0;        ///< scale of the rotations
  double yaw_offset = 0.0;  ///< rad; positive looks to the left of the path
};

/// Walks a closed path for ever: frame i and i + frames_per_lap() have the same pose, bit for bit. Along the path at
/// constant speed, looking ahead; about it sums of sinusoids move all six degrees of freedom.
class WalkMotion : public Motion {
 public:
  WalkMotion(const Walk& walk, double speed, double rate_hz, uint64_t seed);

  SE3 At(double frame) const override;
  int frames_per_lap() const { return frames_per_lap_; }
  double lap_m() const { return spline_.length(); }

 private:
  /// One sinusoid with a whole number of periods in a lap.
  struct Wave {
    double amplitude = 0.0;
    int periods = 1;
    double phase = 0.0;
  };
  using Waves = std::vector<Wave>;
  static double Value(const Waves& waves, double lap_share);

  ClosedSpline spline_;
  double height_m_;
  double yaw_offset_;
  int frames_per_lap_;
  Waves sideways_, vertical_, yaw_, pitch_, roll_;
};

/// Turns on the spot about an axis through a pose of the camera.
class TurningMotion : public Motion {
 public:
  TurningMotion(const SE3& T_w_c, const Eigen::Vector3d& turn_per_frame_w)
      : T_w_c_(T_w_c), turn_per_frame_w_(turn_per_frame_w) {}
  SE3 At(double frame) const override;

 private:
  SE3 T_w_c_;
  Eigen::Vector3d turn_per_frame_w_;  ///< rad
};

/// Poses of a file, as they are.
class ListedMotion : public Motion {
 public:
  explicit ListedMotion(std::vector<SE3> poses) : poses_(std::move(poses)) {}
  SE3 At(double frame) const override;

 private:
  std::vector<SE3> poses_;
};

/// A trajectory file in TUM (`t x y z qx qy qz qw`, seconds) or KITTI format (12 numbers, the rows of [R t]),
/// distinguished by the first line. Throws DatasetError with file, line and reason.
struct FilePoses {
  std::vector<SE3> T_w_c;
  /// Strictly increasing; empty for KITTI files, which have no times.
  std::vector<int64_t> t_ns;
};
FilePoses ReadPoses(const std::string& path);

}  // namespace plslam::synthetic
