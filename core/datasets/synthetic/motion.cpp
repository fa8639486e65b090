// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/datasets/synthetic/exact_math.h"

namespace plslam::synthetic {
namespace {

constexpr int kSteps = 64;  // chords of the arc length table for each control point

}  // namespace

ClosedSpline::ClosedSpline(std::vector<Eigen::Vector2d> control_points) : control_points_(std::move(control_points)) {
  const int steps = static_cast<int>(control_points_.size()) * kSteps;
  lengths_.assign(1, 0.0);
  Eigen::Vector2d previous = Evaluate(0.0).position;
  for (int i = 1; i <= steps; ++i) {
    const Eigen::Vector2d next = Evaluate(static_cast<double>(i) / kSteps).position;
    lengths_.push_back(lengths_.back() + (next - previous).norm());
    previous = next;
  }
}

ClosedSpline::Sample ClosedSpline::Evaluate(double parameter) const {
  const int n = static_cast<int>(control_points_.size());
  const int piece = static_cast<int>(std::floor(parameter));
  const double t = parameter - piece;
  const Eigen::Vector2d& p0 = control_points_[(piece + n - 1) % n];
  const Eigen::Vector2d& p1 = control_points_[piece % n];
  const Eigen::Vector2d& p2 = control_points_[(piece + 1) % n];
  const Eigen::Vector2d& p3 = control_points_[(piece + 2) % n];
  const double s = 1.0 - t;
  const double b0 = s * s * s / 6.0;
  const double b1 = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0;
  const double b2 = (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0;
  const double b3 = t * t * t / 6.0;
  const double d0 = -0.5 * s * s;
  const double d1 = 1.5 * t * t - 2.0 * t;
  const double d2 = 2.0 * s - 1.5 * s * s;
  const double d3 = 0.5 * t * t;
  return {b0 * p0 + b1 * p1 + b2 * p2 + b3 * p3, d0 * p0 + d1 * p1 + d2 * p2 + d3 * p3};
}

ClosedSpline::Pose ClosedSpline::At(double distance) const {
  const auto after = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, distance);
  const auto i = static_cast<int>(after - lengths_.begin());
  const double share = (distance - lengths_[i - 1]) / (lengths_[i] - lengths_[i - 1]);
  const Sample sample = Evaluate((i - 1 + share) / kSteps);
  return {sample.position, sample.derivative / sample.derivative.norm()};
}

std::vector<Eigen::Vector2d> RoundedRectangle(double half_x_m, double half_y_m, double radius_m, double spacing_m) {
  const double straight_x = half_x_m - radius_m;
  const double straight_y = half_y_m - radius_m;
  const std::array<double, 8> pieces = {straight_x,           0.5 * kPi * radius_m, 2.0 * straight_y,
                                        0.5 * kPi * radius_m, 2.0 * straight_x,     0.5 * kPi * radius_m,
                                        2.0 * straight_y,     0.5 * kPi * radius_m};
  const std::array<Eigen::Vector2d, 4> centres = {
      Eigen::Vector2d(straight_x, -straight_y), Eigen::Vector2d(straight_x, straight_y),
      Eigen::Vector2d(-straight_x, straight_y), Eigen::Vector2d(-straight_x, -straight_y)};
  double total = straight_x;
  for (const double piece : pieces) {
    total += piece;
  }
  const int count = static_cast<int>(std::ceil(total / spacing_m));
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < count; ++i) {
    double left = total * i / count;
    int piece = 0;
    while (piece < 7 && left > pieces[piece]) {
      left -= pieces[piece];
      ++piece;
    }
    const bool last_straight = piece == 7 && left > pieces[7];
    if (piece % 2 == 1 && !last_straight) {
      const int corner = piece / 2;
      const double angle = left / radius_m + 0.5 * kPi * (corner - 1);
      points.emplace_back(centres[piece / 2] + radius_m * Eigen::Vector2d(Cos(angle), Sin(angle)));
    } else if (last_straight) {
      points.emplace_back(-straight_x + left - pieces[7], -half_y_m);
    } else {
      const std::array<Eigen::Vector2d, 4> starts = {
          Eigen::Vector2d(0.0, -half_y_m), Eigen::Vector2d(half_x_m, -straight_y),
          Eigen::Vector2d(straight_x, half_y_m), Eigen::Vector2d(-half_x_m, straight_y)};
      const std::array<Eigen::Vector2d, 4> headings = {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(0.0, 1.0),
                                                       Eigen::Vector2d(-1.0, 0.0), Eigen::Vector2d(0.0, -1.0)};
      points.emplace_back(starts[piece / 2] + left * headings[piece / 2]);
    }
  }
  return points;
}

std::vector<Eigen::Vector2d> ScaledToLength(const std::vector<Eigen::Vector2d>& control_points, double length_m) {
  const double scale = length_m / ClosedSpline(control_points).length();
  std::vector<Eigen::Vector2d> scaled;
  scaled.reserve(control_points.size());
  for (const Eigen::Vector2d& point : control_points) {
    scaled.emplace_back(scale * point);
  }
  return scaled;
}

namespace {

constexpr double kDegree = kPi / 180.0;

Eigen::Matrix3d Turned(double yaw, double pitch, double roll) {
  Eigen::Matrix3d about_y;
  about_y << Cos(yaw), 0.0, Sin(yaw), 0.0, 1.0, 0.0, -Sin(yaw), 0.0, Cos(yaw);
  Eigen::Matrix3d about_x;
  about_x << 1.0, 0.0, 0.0, 0.0, Cos(pitch), -Sin(pitch), 0.0, Sin(pitch), Cos(pitch);
  Eigen::Matrix3d about_z;
  about_z << Cos(roll), -Sin(roll), 0.0, Sin(roll), Cos(roll), 0.0, 0.0, 0.0, 1.0;
  return about_y * about_x * about_z;
}

}  // namespace

WalkMotion::WalkMotion(const Walk& walk, double speed, double rate_hz, uint64_t seed)
    : spline_(walk.control_points),
      height_m_(walk.height_m),
      yaw_offset_(walk.yaw_offset),
      frames_per_lap_(std::max(8, static_cast<int>(std::floor(spline_.length() / speed * rate_hz + 0.5)))) {
  Random random(Hash(seed, 0x776f626cULL));
  // Frequencies belong to the default speed, so that another speed plays the same path faster or slower.
  const double lap_s = spline_.length() / walk.speed;
  const auto wave = [&random, lap_s](double amplitude, double frequency_hz) {
    const int periods = std::max(1, static_cast<int>(std::floor(frequency_hz * lap_s + 0.5)));
    return Wave{amplitude, periods, random.Uniform(0.0, 2.0 * kPi)};
  };
  sideways_ = {wave(0.10 * walk.sway, 0.13), wave(0.03 * walk.sway, 0.31)};
  vertical_ = {wave(0.08 * walk.sway, 0.17), wave(0.012 * walk.sway, 1.3)};
  yaw_ = {wave(9.0 * kDegree * walk.turn, 0.14), wave(1.0 * kDegree * walk.turn, 0.7)};
  pitch_ = {wave(3.5 * kDegree * walk.turn, 0.19), wave(0.5 * kDegree * walk.turn, 1.1)};
  roll_ = {wave(3.0 * kDegree * walk.turn, 0.23), wave(0.4 * kDegree * walk.turn, 0.9)};
}

double WalkMotion::Value(const Waves& waves, double lap_share) {
  double sum = 0.0;
  for (const Wave& wave : waves) {
    sum += wave.amplitude * Sin(2.0 * kPi * wave.periods * lap_share + wave.phase);
  }
  return sum;
}

SE3 WalkMotion::At(double frame) const {
  const double lap = frames_per_lap_;
  const double share = (frame - lap * std::floor(frame / lap)) / lap;
  const ClosedSpline::Pose pose = spline_.At(share * spline_.length());
  const Eigen::Vector3d forward(pose.forward.x(), pose.forward.y(), 0.0);
  const Eigen::Vector3d right(pose.forward.y(), -pose.forward.x(), 0.0);
  Eigen::Matrix3d level;
  level.col(0) = right;
  level.col(1) = Eigen::Vector3d(0.0, 0.0, -1.0);
  level.col(2) = forward;
  const Eigen::Vector3d on_path(pose.position.x(), pose.position.y(), height_m_ + Value(vertical_, share));
  const double yaw = Value(yaw_, share) - yaw_offset_;
  return {Eigen::Matrix3d(level * Turned(yaw, Value(pitch_, share), Value(roll_, share))),
          Eigen::Vector3d(on_path + Value(sideways_, share) * right)};
}

SE3 TurningMotion::At(double frame) const {
  const double half = 0.5 * frame * turn_per_frame_w_.norm();
  const Eigen::Vector3d axis = turn_per_frame_w_.normalized();
  const Eigen::Quaterniond turn(Cos(half), Sin(half) * axis.x(), Sin(half) * axis.y(), Sin(half) * axis.z());
  return {turn * T_w_c_.rotation(), T_w_c_.translation()};
}

SE3 ListedMotion::At(double frame) const {
  const double last = static_cast<double>(poses_.size()) - 1.0;
  const double bounded = std::clamp(frame, 0.0, last);
  const auto before = static_cast<size_t>(bounded);
  const double share = bounded - static_cast<double>(before);
  if (share == 0.0) {
    return poses_[before];
  }
  const SE3& a = poses_[before];
  const SE3& b = poses_[before + 1];
  const double sign = a.rotation().dot(b.rotation()) < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector4d mixed = (1.0 - share) * a.rotation().coeffs() + sign * share * b.rotation().coeffs();
  return {Eigen::Quaterniond(mixed), Eigen::Vector3d((1.0 - share) * a.translation() + share * b.translation())};
}

}  // namespace plslam::synthetic
