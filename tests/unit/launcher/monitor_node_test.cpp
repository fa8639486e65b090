// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/monitor_node.h"

#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <string>

#include "core/bus/run_loop.h"
#include "core/process/process_usage.h"
#include "plslam/map_update_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::launcher {
namespace {

using bus::test::Eventually;

/// A monitor on a running bus, and a publisher.
class MonitorNodeTest : public testing::Test {
 protected:
  MonitorNodeTest() { bus_.Start(); }
  ~MonitorNodeTest() override { bus_.Join(); }

  void Say(const std::string& host, int64_t pid, const std::string& state) {
    status_t status{};
    status.process = "viewer";
    status.host = host;
    status.pid = pid;
    status.state = state;
    speaker_.Publish(bus::kStatus, status);
  }

  /// The player has sent so many frames.
  void SaySent(double frames) {
    status_t status{};
    status.process = "player";
    status.counters.resize(1);
    status.counters[0].name = "frames.sent";
    status.counters[0].value = frames;
    status.n_counters = 1;
    speaker_.Publish(bus::kStatus, status);
  }

  /// On the monitor's thread.
  template <class Look>
  auto Ask(const Look& look) {
    std::promise<decltype(look(monitor_))> answer;
    bus_->Post([&] { answer.set_value(look(monitor_)); });
    return answer.get_future().get();
  }

  bool Hears(int64_t n) {
    return Eventually(
        [&] { return Ask([](const MonitorNode& m) { return static_cast<int64_t>(m.processes().size()); }) == n; });
  }

  const bus::BusOptions options_ = [] {
    bus::BusOptions options;
    options.url = bus::test::PrivateUrl();
    return options;
  }();
  bus::test::RunningBus bus_{options_, "plslam"};
  MonitorNode monitor_{*bus_};
  bus::Bus speaker_{options_, "speaker"};
};

TEST_F(MonitorNodeTest, SamePidOnAnotherHostIsAnotherProcess) {
  Say(bus::HostName(), 7, "ready");
  ASSERT_TRUE(Hears(1));
  Say("another-" + bus::HostName(), 7, "finished");
  ASSERT_TRUE(Hears(2));
  EXPECT_EQ(Ask([](const MonitorNode& m) { return m.StateOf(7); }), "ready");
  EXPECT_EQ(Ask([](const MonitorNode& m) { return m.StateOf(8); }), "");
}

TEST_F(MonitorNodeTest, PlayerWaitsForTimeIfItsFramesHavePoses) {
  const auto waits = [&](double in_s) {
    return Ask([=](const MonitorNode& m) { return m.PlayerWaitsForTime(bus::NowS() + in_s); });
  };
  EXPECT_FALSE(waits(0.0)) << "no player was heard";
  SaySent(2);
  ASSERT_TRUE(Hears(1));
  EXPECT_FALSE(waits(0.0)) << "a frame is out";
  pose_t pose{};
  pose.frame_id = 1;
  speaker_.Publish(bus::kPose, pose);
  EXPECT_TRUE(Eventually([&] { return waits(0.0); }));
  EXPECT_FALSE(waits(60.0)) << "silent for a minute";
  const auto say = [&](const char* event, const char* pace) {
    stream_t stream{};
    stream.event = event;
    stream.pace = pace;
    speaker_.Publish(bus::kStream, stream);
  };
  say("end", "realtime");
  EXPECT_TRUE(Eventually([&] { return !waits(0.0); })) << "no frame will come any more";
  say("begin", "realtime");
  EXPECT_TRUE(Eventually([&] { return waits(0.0); }));
  say("begin", "lockstep");
  EXPECT_TRUE(Eventually([&] { return !waits(0.0); })) << "it waits for nothing but what it reads";
}

TEST_F(MonitorNodeTest, FramesWithoutAPoseAreUnanswered) {
  const auto unanswered = [&](int64_t n) {
    return Eventually([&] { return Ask([](const MonitorNode& m) { return m.frames().unanswered; }) == n; });
  };
  SaySent(7);
  EXPECT_TRUE(unanswered(7));
  pose_t pose{};
  pose.frame_id = 3;
  pose.n_skipped_frames = 3;
  speaker_.Publish(bus::kPose, pose);
  EXPECT_TRUE(unanswered(3)) << "it has passed over three, and not come to three";
  stream_t end{};
  end.event = "end";
  end.n_frames = 9;
  speaker_.Publish(bus::kStream, end);
  EXPECT_TRUE(unanswered(5)) << "the stream tells more exactly than a status of a second ago";
  const auto has_all = [](const MonitorNode& m) { return m.SignsOfEnd({1, 2, false}, bus::NowS()).has_all_poses; };
  EXPECT_FALSE(Ask(has_all));
  pose.frame_id = 8;
  pose.n_skipped_frames = 4;
  speaker_.Publish(bus::kPose, pose);
  EXPECT_TRUE(unanswered(0));
  EXPECT_TRUE(Ask(has_all));
}

TEST_F(MonitorNodeTest, LastPoseIsTheLastOfAll) {
  stream_t end{};
  end.event = "end";
  end.n_frames = 5;
  speaker_.Publish(bus::kStream, end);
  pose_t pose{};
  pose.frame_id = 3;
  speaker_.Publish(bus::kPose, pose);
  const auto signs = [&] {
    return Ask([](const MonitorNode& m) { return m.SignsOfEnd({1, 2, true}, bus::NowS()); });
  };
  ASSERT_TRUE(Eventually([&] { return signs().stream_ended && signs().poses == 1; }));
  EXPECT_FALSE(signs().has_all_poses);
  pose.frame_id = 4;
  pose.keyframe_id = 0;
  speaker_.Publish(bus::kPose, pose);
  EXPECT_TRUE(Eventually([&] { return signs().has_all_poses; })) << "earlier ones were lost before the tracker";
  EXPECT_FALSE(signs().has_map) << "there is none yet";
  EXPECT_EQ(Ask([](const MonitorNode& m) { return m.committed_keyframe(); }), KeyframeName());
  map_update_t update{};
  update.version = update.n_pages = 1;
  update.committed = 1;
  speaker_.Publish(bus::kMapUpdate, update);
  EXPECT_TRUE(Eventually([&] { return signs().has_map; }));
  EXPECT_EQ(Ask([](const MonitorNode& m) { return m.committed_keyframe().number; }), 0);
}

TEST_F(MonitorNodeTest, ViewerOfAnotherHostIsNoSignOfLife) {
  Say("another-" + bus::HostName(), 7, "running");
  ASSERT_TRUE(Hears(1));
  const auto heard_s = [](const MonitorNode& m) { return m.Signs(7, bus::NowS()).viewer_heard_s; };
  EXPECT_LT(Ask(heard_s), 0.0);
  Say(bus::HostName(), 7, "running");
  ASSERT_TRUE(Hears(2));
  EXPECT_NEAR(Ask(heard_s), bus::NowS(), 60.0);
}

}  // namespace
}  // namespace plslam::launcher
