// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/node/run_end.h"

#include <gtest/gtest.h>

#include "plslam/run_t.hpp"

namespace plslam {
namespace {

constexpr int kSilentTicks = static_cast<int>(RunEnd::kSilence / RunEnd::kTick);
constexpr int kDay = 86'400 * 4;

/// A stream of four frames, of which the last one is the newest keyframe, number 0.
class RunEndTest : public testing::Test {
 protected:
  void Begin(RunEnd& end) {
    run_t message{};
    message.event = "begin";
    EXPECT_TRUE(end.OnRun(message));
  }
  void End(RunEnd& end, int64_t session_keyframe_id) {
    run_t message{};
    message.event = "end";
    message.n_poses = 4;
    message.session_keyframe_id = session_keyframe_id;
    EXPECT_TRUE(end.OnRun(message));
  }
  void Commit() {
    MapUpdate update;
    update.newest.number = 0;
    update.committed = true;
    map_.Add(update);
  }
  /// Whether the run is over this long after the last message.
  bool IsOver(RunEnd& end, int ticks = 2) const {
    end.OnMessage();
    for (int i = 0; i < ticks; ++i) end.OnTick();
    return end.IsOver(received_, map_);
  }

  RunEnd::Received received_{.has_rig = true, .n_poses = 4, .keyframe = KeyframeName{{}, 0}, .is_tracked = true};
  NewestKeyframes map_;
};

TEST_F(RunEndTest, UnderALauncherNoSilenceEndsTheWait) {
  for (const bool has_launcher : {true, false}) {
    RunEnd end(has_launcher);
    if (!has_launcher) Begin(end);
    end.OnStream(true);
    end.OnMapper();
    EXPECT_EQ(end.state(), RunEnd::State::kAwaited);
    EXPECT_FALSE(IsOver(end, kDay)) << "mapping_process is slow";
  }
}

TEST_F(RunEndTest, AnnouncedPosesAndMapEndIt) {
  RunEnd end(true);
  End(end, 0);
  EXPECT_FALSE(IsOver(end, kDay)) << "the end of the stream has not arrived";
  end.OnStream(true);
  Commit();
  received_.n_poses = 3;
  EXPECT_FALSE(IsOver(end)) << "a restarted viewer receives the poses of two trackers";
  received_.n_poses = 4;
  EXPECT_TRUE(IsOver(end));
  received_.n_poses.reset();
  EXPECT_TRUE(IsOver(end)) << "dense_process reads no poses";
  received_.is_tracked = false;
  EXPECT_TRUE(IsOver(end)) << "no more will come";
  received_.has_rig = false;
  EXPECT_FALSE(IsOver(end));
}

TEST_F(RunEndTest, MessagesOfOtherProcessesAreAwaited) {
  for (const bool has_launcher : {true, false}) {
    RunEnd end(has_launcher);
    if (has_launcher) End(end, 0);
    end.OnStream(true);
    Commit();
    received_.more_may_come = true;
    EXPECT_FALSE(IsOver(end, kSilentTicks));
    EXPECT_TRUE(IsOver(end, kSilentTicks + 1)) << "a dense_process that hangs";
    received_.more_may_come = false;
    EXPECT_TRUE(IsOver(end));
  }
}

TEST_F(RunEndTest, AnnouncedKeyframeIsAwaited) {
  RunEnd end(true);
  end.OnStream(true);
  End(end, 0);
  EXPECT_FALSE(IsOver(end));
  EXPECT_FALSE(IsOver(end, kSilentTicks));
  EXPECT_TRUE(IsOver(end, kSilentTicks + 1)) << "lost";
  Commit();
  EXPECT_TRUE(IsOver(end));
  RunEnd without_map(true);
  without_map.OnStream(true);
  without_map.OnMapper();
  End(without_map, -1);
  map_ = NewestKeyframes();
  EXPECT_TRUE(IsOver(without_map)) << "the launcher does not wait for a map";
}

TEST_F(RunEndTest, ByHandStreamTrackerAndMapEndIt) {
  RunEnd end(false);
  EXPECT_FALSE(IsOver(end, kDay)) << "a pause of the player";
  end.OnStream(true);
  received_.is_tracked = false;
  EXPECT_FALSE(IsOver(end, kSilentTicks));
  EXPECT_TRUE(IsOver(end, kSilentTicks + 1)) << "the last frame was lost";
  received_.is_tracked = true;
  EXPECT_TRUE(IsOver(end));
  end.OnMapper();
  EXPECT_FALSE(IsOver(end));
  Commit();
  EXPECT_TRUE(IsOver(end));
  received_.keyframe->number = 1;
  EXPECT_FALSE(IsOver(end)) << "keyframe 1 is not committed";
  end.OnStream(false);
  EXPECT_FALSE(IsOver(end, kDay)) << "another part of the stream has begun";
}

TEST_F(RunEndTest, MessagesDelayIt) {
  RunEnd end(false);
  end.OnStream(true);
  EXPECT_FALSE(IsOver(end, 1));
  end.OnTick();
  EXPECT_TRUE(end.IsOver(received_, map_));
  end.OnMessage();
  EXPECT_FALSE(end.IsOver(received_, map_));
}

TEST_F(RunEndTest, NewStreamForgetsOnlyTheEndOfItsRun) {
  RunEnd end(false);
  end.OnStream(true);
  End(end, -1);
  end.OnNewStream();
  EXPECT_EQ(end.state(), RunEnd::State::kByHand);
  EXPECT_FALSE(IsOver(end, kDay)) << "the new stream has not ended";
  Begin(end);
  end.OnNewStream();
  EXPECT_EQ(end.state(), RunEnd::State::kAwaited) << "the run of this stream had begun before";
  RunEnd launched(true);
  End(launched, -1);
  launched.OnNewStream();
  EXPECT_EQ(launched.state(), RunEnd::State::kAwaited);
}

TEST_F(RunEndTest, UnknownEventChangesNothing) {
  RunEnd end(false);
  run_t message{};
  message.event = "pause";
  EXPECT_FALSE(end.OnRun(message));
  EXPECT_EQ(end.state(), RunEnd::State::kByHand);
}

}  // namespace
}  // namespace plslam
