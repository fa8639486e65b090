// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/tracker_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace plslam::vo {
namespace {

class TrackerStateFile : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }

  const std::string path_ = testing::TempDir() + "tracker_state_" + std::to_string(getpid());
};

TrackerState SomeState() {
  TrackerState state;
  state.settings = "vo:\n  features: both\n";
  state.camera = {1, 2, 3};
  state.n_restored = 2;
  state.session.id = 77;
  state.session.lockstep = true;
  state.session.last_t_ns = 123456789;
  state.session.last_frame_id = 41;
  state.session.last_source = -9;
  state.session.recent.emplace_back().frame_id = 40;
  state.session.recent.emplace_back().frame_id = 41;
  state.session.anchor.Begin(5);
  state.session.anchor.OnMap(false);
  state.adopted_keyframe_id = 6;
  state.odometry = {9, 8, 7};
  state.keyframe.name.number = 7;
  state.keyframe.T_odom_kf = SE3::Exp(Vector6d::Constant(0.1));
  state.keyframe.features.points.resize(2);
  state.keyframe.features.points[1].disparity_px = 12.5;
  state.keyframe.features.lines.resize(1);
  state.keyframe.point_landmark_ids = {3, -1};
  state.keyframe.line_landmark_ids = {8};
  return state;
}

TEST_F(TrackerStateFile, RoundTrip) {
  const TrackerState state = SomeState();
  WriteTrackerState(path_, state);
  const TrackerState back = ReadTrackerState(path_);
  EXPECT_EQ(back.settings, state.settings);
  EXPECT_EQ(back.camera, state.camera);
  EXPECT_EQ(back.n_restored, state.n_restored);
  EXPECT_EQ(back.session.id, state.session.id);
  EXPECT_EQ(back.session.lockstep, state.session.lockstep);
  EXPECT_EQ(back.session.last_t_ns, state.session.last_t_ns);
  EXPECT_EQ(back.session.last_frame_id, state.session.last_frame_id);
  EXPECT_EQ(back.session.last_source, state.session.last_source);
  ASSERT_EQ(back.session.recent.size(), 2U);
  EXPECT_EQ(back.session.recent.back().frame_id, 41);
  EXPECT_EQ(back.session.anchor.t_ns(), 5);
  EXPECT_EQ(back.session.anchor.state(), SessionAnchor::State::kUnanchored);
  EXPECT_EQ(back.adopted_keyframe_id, state.adopted_keyframe_id);
  EXPECT_EQ(back.odometry, state.odometry);
  EXPECT_EQ(back.keyframe.name.number, 7);
  EXPECT_EQ(back.keyframe.T_odom_kf.translation(), state.keyframe.T_odom_kf.translation());
  EXPECT_EQ(back.keyframe.features.points.at(1).disparity_px, 12.5);
  EXPECT_EQ(back.keyframe.features.lines.size(), 1U);
  EXPECT_EQ(back.keyframe.point_landmark_ids, state.keyframe.point_landmark_ids);
  EXPECT_EQ(back.keyframe.line_landmark_ids, state.keyframe.line_landmark_ids);
}

TEST_F(TrackerStateFile, TruncatedAndMissingFilesAreNamed) {
  using testing::HasSubstr;
  using testing::ThrowsMessage;
  EXPECT_THAT([this] { ReadTrackerState(path_); }, ThrowsMessage<std::runtime_error>(HasSubstr(path_)));
  WriteTrackerState(path_, SomeState());
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 1);
  EXPECT_THAT([this] { ReadTrackerState(path_); }, ThrowsMessage<std::runtime_error>(HasSubstr("truncated")));
}

}  // namespace
}  // namespace plslam::vo
