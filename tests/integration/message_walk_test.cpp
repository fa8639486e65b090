// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/message_walk.h"

#include <gtest/gtest.h>

#include "core/bus/transport/wire.h"
#include "plslam/loop_closure_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam {
namespace {

using test::FirstDifference;

template <class Message>
std::string Difference(const Message& message, const Message& logged, const std::set<std::string>& ignored = {}) {
  return FirstDifference(*FindMessageLayout(Message::getTypeName()), bus::Encoded(message), bus::Encoded(logged),
                         ignored);
}

pose_t SomePose() {
  pose_t pose{};
  pose.n_stages = 2;
  pose.stages.resize(2);
  pose.stages[0].name = "points";
  pose.stages[1].name = "track";
  return pose;
}

TEST(FirstDifference, NamesTheMemberAndBothValues) {
  pose_t logged = SomePose(), pose = SomePose();
  EXPECT_EQ(Difference(pose, logged), "");
  logged.T_odom_c.position_m[1] = 0.5;
  pose.T_odom_c.position_m[1] = 0.25;
  pose.n_points = 7;
  EXPECT_EQ(Difference(pose, logged), "T_odom_c.position_m[1] is 0.25, in the log 0.5");
}

TEST(FirstDifference, TextsOfDifferentLength) {
  pose_t logged = SomePose(), pose = SomePose();
  pose.stages[1].name = "tracking";
  EXPECT_EQ(Difference(pose, logged), "stages[1].name is \"tracking\", in the log \"track\"");
  EXPECT_EQ(Difference(logged, pose), "stages[1].name is \"track\", in the log \"tracking\"");
}

TEST(FirstDifference, ListsOfDifferentLengthDifferInSize) {
  pose_t logged = SomePose(), pose = SomePose();
  pose.stages.pop_back();
  pose.n_stages = 1;
  EXPECT_EQ(Difference(pose, logged), "n_stages is 1, in the log 2");
}

TEST(FirstDifference, SkipsIgnoredMembers) {
  pose_t logged = SomePose(), pose = SomePose();
  pose.header.source = 5;
  pose.stages[0].ms = 3.0;
  EXPECT_EQ(Difference(pose, logged, {"stage_t.ms"}), "header.source is 5, in the log 0");
  EXPECT_EQ(Difference(pose, logged, {"stage_t.ms", "header_t.source"}), "");
}

TEST(FirstDifference, MessageOfAnotherTypeIsReported) {
  const std::vector<uint8_t> status = bus::Encoded(status_t{}), pose = bus::Encoded(pose_t{});
  const MessageLayout& layout = *FindMessageLayout("pose_t");
  EXPECT_EQ(FirstDifference(layout, status, pose), "it is no pose_t");
  EXPECT_EQ(FirstDifference(layout, pose, status), "in the log it is no pose_t");
}

TEST(Rename, ReplacesIdsInAllMembers) {
  loop_closure_t closure{};
  closure.header.source = closure.map_version.numbering = int64_t{1} << 40;
  closure.header.session = 3;
  closure.n_names = 1;
  closure.names.resize(1);
  closure.names[0].session = 3;
  closure.names[0].session_keyframe_id = 4;
  std::vector<uint8_t> bytes = bus::Encoded(closure);
  test::Rename(*FindMessageLayout("loop_closure_t"), {{int64_t{1} << 40, -8}, {3, 9}}, &bytes);
  closure.header.source = closure.map_version.numbering = -8;
  closure.header.session = closure.names[0].session = 9;
  EXPECT_EQ(bytes, bus::Encoded(closure));
}

}  // namespace
}  // namespace plslam
