// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/vo/small_scene.h"

#include <random>
#include <utility>

#include <gtest/gtest.h>

namespace plslam::test {

Scene MakeScene() {
  Scene scene;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < 40; ++i) scene.points.push_back({any(random), any(random), 4.0 + any(random)});
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p{any(random), -0.8 + 0.2 * any(random), 4.0 + any(random)};
    scene.lines.push_back({p, p + Eigen::Vector3d{any(random), 1.5, 0.5 * any(random)}});
  }
  return scene;
}

StereoLine SeeLine(const Eigen::Vector3d& p, const Eigen::Vector3d& q, bool depth) {
  StereoLine seen;
  seen.left.segment = {p.head<2>(), q.head<2>()};
  seen.sigma_px = seen.sigma_disparity_p_px = seen.sigma_disparity_q_px = kSigma_px;
  if (!depth) return seen;
  seen.disparity_p_px = p.z();
  seen.disparity_q_px = q.z();
  return seen;
}

StereoPoint SeePoint(const Eigen::Vector3d& uvd, bool depth) {
  StereoPoint seen;
  seen.left.px = uvd.head<2>();
  seen.sigma_px = seen.sigma_disparity_px = kSigma_px;
  if (depth) seen.disparity_px = uvd.z();
  return seen;
}

vo::TrackedFrame See(const Scene& scene, const SE3& T_odom_c, const View& view) {
  std::mt19937 random(view.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(0.0, 0.2);
  const SE3 T_c_odom = T_odom_c.Inverse();
  const auto measure = [&](const Eigen::Vector3d& p_odom) -> Eigen::Vector3d {
    const Eigen::Vector3d noise{normal(random), normal(random), normal(random)};
    return kCamera.ProjectStereo(T_c_odom * p_odom) + view.noise_px * noise;
  };
  StereoFeatures features;
  std::vector<vo::FeatureTrack> point_tracks, line_tracks;
  for (size_t i = 0; i < scene.points.size(); ++i) {
    const auto id = static_cast<int64_t>(i);
    const StereoPoint seen = SeePoint(measure(scene.points[i]), view.depth);
    if (view.missed_points.contains(id)) continue;
    features.points.push_back(seen);
    point_tracks.push_back({TrackId(id), 1, LandmarkId(100 + id)});
  }
  for (size_t i = 0; i < scene.lines.size(); ++i) {
    const auto id = static_cast<int64_t>(i);
    const Segment3& line = scene.lines[i];
    const double from = view.cut ? share(random) : 0.0;
    const double to = view.cut ? 1.0 - share(random) : 1.0;
    const StereoLine seen =
        SeeLine(measure(line.p + from * (line.q - line.p)), measure(line.p + to * (line.q - line.p)), view.depth);
    if (view.missed_lines.contains(id)) continue;
    features.lines.push_back(seen);
    line_tracks.push_back({TrackId(id), 1, LandmarkId(100 + id)});
  }
  vo::TrackedFrame frame(std::move(features));
  frame.point_tracks = std::move(point_tracks);
  frame.line_tracks = std::move(line_tracks);
  return frame;
}

vo::LocalLandmarks LandmarksOf(Scene scene, const Eigen::Vector3d& offset) {
  for (Eigen::Vector3d& p : scene.points) p += offset;
  for (Segment3& line : scene.lines) line = {line.p + offset, line.q + offset};
  vo::VoOptions options;
  options.landmarks.max_relative_depth_sigma = 1.0;
  vo::LocalLandmarks landmarks(kCamera, options);
  vo::TrackedFrame frame = See(scene, SE3());
  for (auto* tracks : {&frame.point_tracks, &frame.line_tracks}) tracks->assign(tracks->size(), {});
  landmarks.Create(SE3(), frame);
  EXPECT_EQ(landmarks.points.landmarks().size(), scene.points.size());
  EXPECT_EQ(landmarks.lines.landmarks().size(), scene.lines.size());
  return landmarks;
}

Eigen::Vector4d LineError(const StereoLine& seen, const Segment3& truth_odom, const SE3& T_odom_c) {
  const SE3 T_c_odom = T_odom_c.Inverse();
  const Eigen::Vector3d p = kCamera.ProjectStereo(T_c_odom * truth_odom.p);
  const Eigen::Vector3d q = kCamera.ProjectStereo(T_c_odom * truth_odom.q);
  const Eigen::Vector3d left = LineThrough({p.head<2>(), q.head<2>()});
  const auto disparity_at = [&](const Eigen::Vector2d& px) {
    return p.z() + (q.z() - p.z()) * (px.y() - p.y()) / (q.y() - p.y());
  };
  const Segment2& segment = seen.left.segment;
  return {left.dot(segment.p.homogeneous()), left.dot(segment.q.homogeneous()),
          seen.disparity_p_px - disparity_at(segment.p), seen.disparity_q_px - disparity_at(segment.q)};
}

Eigen::Vector3d PointError(const StereoPoint& seen, const Eigen::Vector3d& truth_odom, const SE3& T_odom_c) {
  const Eigen::Vector3d uvd = kCamera.ProjectStereo(T_odom_c.Inverse() * truth_odom);
  return Eigen::Vector3d(seen.left.px.x(), seen.left.px.y(), seen.disparity_px) - uvd;
}

}  // namespace plslam::test
