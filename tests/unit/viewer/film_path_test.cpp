// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/film.h"

#include <gtest/gtest.h>

#include "tests/unit/run/frame_poses.h"

namespace plslam::viewer {
namespace {

/// Keyframe `id` of the session of SomePose at a frame, moved sideways.
MapKeyframe MovedKeyframe(KeyframeId id, int64_t frame_id, double sideways_m) {
  MapKeyframe keyframe;
  keyframe.id = id;
  keyframe.name.session = 7;
  keyframe.frame_id = FrameId(frame_id);
  keyframe.T_odom_kf = SomePose(frame_id).T_odom_c;
  keyframe.T_w_kf = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(sideways_m, 0.0, 0.0)) * keyframe.T_odom_kf;
  return keyframe;
}

FilmPath PathOf(const std::vector<FramePose>& poses) {
  FilmPath path;
  for (FramePose pose : poses) {
    pose.T_w_odom = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(9.0, 0.0, 0.0));
    path.Add(pose);
  }
  return path;
}

/// Returns the sideways offset of each position, and checks that each is as far ahead as odometry measured.
std::vector<double> Sideways(const std::vector<Eigen::Vector3d>& path, const std::vector<int64_t>& frames) {
  std::vector<double> x;
  for (size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(path[i].z(), static_cast<double>(frames.at(i)));
    x.push_back(path[i].x());
  }
  return x;
}

TEST(FilmPath, WithoutAMapItIsAsPublished) {
  EXPECT_EQ(Sideways(PathOf({SomePose(0), SomePose(1)}).In(Map()), {0, 1}), (std::vector<double>{9.0, 9.0}));
}

TEST(FilmPath, FramesMoveWithTheirCorrectedKeyframe) {
  const FilmPath path = PathOf({SomePose(0), SomePose(2), SomePose(3), SomePose(6), SomePose(8)});
  Map map;
  map.Put(MovedKeyframe(0, 2, 1.0));
  map.Put(MovedKeyframe(1, 6, 2.0));
  const std::vector<int64_t> frames{0, 2, 3, 6, 8};
  EXPECT_EQ(Sideways(path.In(map), frames), (std::vector<double>{1.0, 1.0, 1.0, 2.0, 2.0}));
  map.Put(MovedKeyframe(1, 6, -3.0));
  EXPECT_EQ(Sideways(path.In(map), frames), (std::vector<double>{1.0, 1.0, 1.0, -3.0, -3.0}));
}

TEST(FilmPath, LostFramesSplitThePath) {
  const FilmPath path =
      PathOf({SomePose(0, TrackingState::kInitialising), SomePose(1), SomePose(3), SomePose(4, TrackingState::kLost),
              SomePose(5), SomePose(6), SomePose(7, TrackingState::kLost), SomePose(8)});
  Map map;
  map.Put(MovedKeyframe(0, 2, 1.0));
  map.Put(MovedKeyframe(1, 6, 2.0));
  EXPECT_EQ(Sideways(path.In(map), {1, 3, 5, 6, 8}), (std::vector<double>{1.0, 1.0, 2.0, 2.0, 9.0}));
}

TEST(FilmPath, AnotherSessionIsNotMoved) {
  FramePose pose = SomePose(3);
  pose.session = 8;
  Map map;
  map.Put(MovedKeyframe(0, 2, 1.0));
  EXPECT_EQ(Sideways(PathOf({pose}).In(map), {3}), (std::vector<double>{9.0}));
}

}  // namespace
}  // namespace plslam::viewer
