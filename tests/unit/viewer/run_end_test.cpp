// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/run_end.h"

#include <gtest/gtest.h>

namespace plslam::viewer {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

constexpr milliseconds kQuiet(500);
constexpr RunEnd::Received kAll{.has_rig = true, .pictures_may_come = false};

/// A stream of four frames; the last one is a keyframe.
class RunEndTest : public testing::Test {
 protected:
  void Receive(std::initializer_list<int64_t> frames) {
    for (const int64_t frame : frames) {
      FramePose pose;
      pose.frame_id = FrameId(frame);
      pose.state = TrackingState::kTracking;
      pose.keyframe_id = frame == 3 ? 0 : -1;
      recorder_.AddPose(pose);
    }
  }
  void Commit() {
    MapUpdate update;
    update.newest.number = 0;
    update.committed = true;
    map_.Add(update);
  }
  bool IsOver(const RunEnd& end, milliseconds silence, const RunEnd::Received& received = kAll) const {
    return end.IsOver(recorder_, map_, received, silence);
  }

  Recorder recorder_;
  NewestKeyframes map_;
};

TEST_F(RunEndTest, UnderALauncherNoSilenceEndsTheWait) {
  for (const bool has_launcher : {true, false}) {
    RunEnd end(has_launcher);
    if (!has_launcher) end.OnBegin();
    Receive({0, 1, 2, 3});
    recorder_.SetEnd(4);
    end.OnMapper();
    EXPECT_EQ(end.state(), RunEnd::State::kAwaited);
    EXPECT_FALSE(IsOver(end, hours(24))) << "mapping_process is slow";
  }
}

TEST_F(RunEndTest, SurfacesAreAwaited) {
  const RunEnd::Received kNoSurfaces{.has_rig = true, .surfaces_may_come = true};
  for (const bool has_launcher : {true, false}) {
    RunEnd end(has_launcher);
    if (has_launcher) end.OnEnd({4, {SessionId(0), 0}});
    Receive({0, 1, 2, 3});
    recorder_.SetEnd(4);
    Commit();
    EXPECT_FALSE(IsOver(end, kQuiet, kNoSurfaces));
    EXPECT_TRUE(IsOver(end, kQuiet));
    EXPECT_TRUE(IsOver(end, hours(1), kNoSurfaces)) << "a dense_process that hangs";
  }
}

TEST_F(RunEndTest, AnnouncedPosesAndMapEndIt) {
  RunEnd end(true);
  end.OnEnd({4, {SessionId(0), 0}});
  EXPECT_FALSE(IsOver(end, hours(24))) << "the end of the stream has not arrived";
  recorder_.SetEnd(4);
  Receive({0, 1, 3});
  Commit();
  EXPECT_FALSE(IsOver(end, kQuiet)) << "a restarted viewer receives the poses of two trackers";
  Receive({2});
  EXPECT_TRUE(IsOver(end, kQuiet));
  EXPECT_FALSE(IsOver(end, kQuiet, {.has_rig = false}));
  EXPECT_TRUE(IsOver(end, kQuiet, {.has_rig = true, .pictures_may_come = true})) << "none will come";
}

TEST_F(RunEndTest, AnnouncedKeyframeIsAwaited) {
  RunEnd end(true);
  recorder_.SetEnd(4);
  Receive({0, 1, 2, 3});
  end.OnEnd({4, {SessionId(0), 0}});
  EXPECT_FALSE(IsOver(end, kQuiet));
  EXPECT_TRUE(IsOver(end, RunEnd::kSilence + kQuiet)) << "lost";
  Commit();
  EXPECT_TRUE(IsOver(end, kQuiet));
  RunEnd without_map(true);
  without_map.OnMapper();
  without_map.OnEnd({4, {}});
  map_ = NewestKeyframes();
  EXPECT_TRUE(IsOver(without_map, kQuiet)) << "the launcher does not wait for a map";
}

TEST_F(RunEndTest, ByHandTheStreamEndsIt) {
  RunEnd end(false);
  Receive({0, 1, 2});
  EXPECT_FALSE(IsOver(end, hours(24))) << "a pause of the player";
  recorder_.SetEnd(4);
  EXPECT_FALSE(IsOver(end, kQuiet));
  EXPECT_FALSE(IsOver(end, RunEnd::kSilence));
  EXPECT_TRUE(IsOver(end, RunEnd::kSilence + kQuiet)) << "the last frame was lost";
  Receive({3});
  EXPECT_TRUE(IsOver(end, kQuiet));
  EXPECT_FALSE(IsOver(end, kQuiet, {.has_rig = true, .pictures_may_come = true}));
  end.OnMapper();
  EXPECT_FALSE(IsOver(end, kQuiet));
  Commit();
  EXPECT_TRUE(IsOver(end, kQuiet));
}

TEST_F(RunEndTest, FramesLostBeforeTheTrackerAreNotAwaited) {
  const RunEnd end(false);
  recorder_.SetEnd(4);
  Receive({0, 3});
  EXPECT_TRUE(IsOver(end, kQuiet));
}

TEST_F(RunEndTest, NewStreamForgetsOnlyTheEndOfItsRun) {
  RunEnd end(false);
  end.OnEnd({4, {}});
  end.OnNewStream();
  EXPECT_EQ(end.state(), RunEnd::State::kByHand);
  end.OnBegin();
  end.OnNewStream();
  EXPECT_EQ(end.state(), RunEnd::State::kAwaited) << "the run of this stream had begun before";
  RunEnd launched(true);
  launched.OnEnd({4, {}});
  launched.OnNewStream();
  EXPECT_EQ(launched.state(), RunEnd::State::kAwaited);
}

}  // namespace
}  // namespace plslam::viewer
