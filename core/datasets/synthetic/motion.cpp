// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/datasets/synthetic/exact_math.h"

namespace plslam::synthetic {
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
