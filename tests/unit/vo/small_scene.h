// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "vo_process/tracking/landmarks/local_landmarks.h"

namespace plslam::test {

inline const StereoCamera kCamera{400.0, 320.0, 240.0, 0.12, 640, 480};
inline constexpr double kSigma_px = 0.3;

/// Points and upright segments 3 to 5 m in front of the origin, in the odometry frame.
struct Scene {
  std::vector<Eigen::Vector3d> points;
  std::vector<Segment3> lines;
};

Scene MakeScene();

/// View of the scene in a frame; landmark i has index i within its feature type.
struct View {
  double noise_px = 0.0;
  uint32_t seed = 1;
  bool depth = true;
  /// Detected lines have different end points in each frame.
  bool cut = false;
  std::set<int64_t> missed_points = {};
  std::set<int64_t> missed_lines = {};
};

StereoLine SeeLine(const Eigen::Vector3d& p, const Eigen::Vector3d& q, bool depth);
StereoPoint SeePoint(const Eigen::Vector3d& uvd, bool depth);
vo::TrackedFrame See(const Scene& scene, const SE3& T_odom_c, const View& view = {});

/// Landmarks where the scene has them, but for `offset`, in its order.
vo::LocalLandmarks LandmarksOf(Scene scene, const Eigen::Vector3d& offset = Eigen::Vector3d::Zero());

/// Distances of a feature's ends from where the line is in the left image, and errors of the disparities there.
Eigen::Vector4d LineError(const StereoLine& seen, const Segment3& truth_odom, const SE3& T_odom_c);

Eigen::Vector3d PointError(const StereoPoint& seen, const Eigen::Vector3d& truth_odom, const SE3& T_odom_c);

}  // namespace plslam::test
