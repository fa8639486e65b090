// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/history_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/process/process_usage.h"
#include "plslam/camera_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::launcher {
namespace {

using bus::test::Eventually;
using bus::test::PrivateUrl;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::Pair;

bus::BusOptions On(const std::string& url) {
  bus::BusOptions options;
  options.url = url;
  return options;
}

/// A history keeper on a running bus. Its bus is joined before the data of its handlers are destroyed.
class RunningKeeper {
 public:
  RunningKeeper(const std::string& url, const std::string& folder) : bus_(On(url)), keeper_(*bus_, folder) {
    bus_.Start();
  }
  ~RunningKeeper() { bus_.Join(); }
  RunningKeeper(const RunningKeeper&) = delete;
  RunningKeeper& operator=(const RunningKeeper&) = delete;

  bus::Bus& bus() { return *bus_; }
  HistoryKeeper* operator->() { return &keeper_; }
  /// Reports the exit of a process on the bus's thread, as the launcher does.
  void Exit(pid_t pid) {
    bus_->Post([this, pid] { keeper_.OnExit(pid); });
  }

 private:
  bus::test::RunningBus bus_;
  HistoryKeeper keeper_;
};

void Say(bus::Bus& bus, int64_t session, int64_t frame_id) {
  pose_t pose{};
  pose.header.session = session;
  pose.header.t_ns = 10 * frame_id;
  pose.frame_id = frame_id;
  bus.Publish(bus::kPose, pose);
}

void SayAlive(bus::Bus& bus, int64_t pid) {
  status_t status{};
  status.process = "vo";
  status.pid = pid;
  status.host = bus::HostName();
  bus.Publish(bus::kStatus, status);
}

/// A listener that starts late, with the messages that it receives.
class LateListener {
 public:
  explicit LateListener(const std::string& url) : bus_(On(url)) {
    bus_->Subscribe<pose_t>(bus::kPose, [this](const pose_t& m) {
      const std::scoped_lock lock(mutex_);
      poses_.emplace_back(m.header.session, m.frame_id);
    });
    bus_.Start();
  }
  std::vector<std::pair<int64_t, int64_t>> poses() {
    const std::scoped_lock lock(mutex_);
    return poses_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<int64_t, int64_t>> poses_;
  bus::test::RunningBus bus_;
};

TEST(HistoryKeeper, RepublishesMessagesOfExitedProcesses) {
  const std::string url = PrivateUrl();
  RunningKeeper keeper(url, testing::TempDir());
  {
    bus::Bus dies(On(url), "vo"), lives(On(url), "vo");
    SayAlive(dies, 7);
    SayAlive(lives, 8);
    for (int i = 0; i < 3; ++i) Say(dies, 100, i);
    Say(lives, 200, 3);
    ASSERT_TRUE(Eventually([&] { return keeper->kept() == 4; }));
    EXPECT_EQ(keeper->said_again(), 0);
  }
  keeper.Exit(7);
  ASSERT_TRUE(Eventually([&] { return keeper->said_again() == 3; }));
  LateListener late(url);
  ASSERT_TRUE(Eventually([&] { return late.poses().size() >= 3; }));
  EXPECT_THAT(late.poses(), ElementsAre(Pair(100, 0), Pair(100, 1), Pair(100, 2)))
      << "of one that is not known to have died nothing is said";
  keeper.Exit(7);
  keeper.Exit(8);
  ASSERT_TRUE(Eventually([&] { return late.poses().size() == 4; }));
  EXPECT_EQ(keeper->said_again(), 4) << "once";
  EXPECT_EQ(keeper->kept(), 4) << "what it says itself is not kept again";
}

TEST(HistoryKeeper, RepublishesCameraAndStreamOfExitedPlayer) {
  const std::string url = PrivateUrl();
  RunningKeeper keeper(url, testing::TempDir());
  std::atomic<int> before = 0;
  std::atomic<int> cameras = 0;
  std::atomic<int64_t> stream = 0;
  {
    bus::test::RunningBus listener(On(url));
    listener->Subscribe<camera_t>(bus::kCamera, [&](const camera_t&) { ++before; });
    listener.Start();
    bus::Bus player(On(url), "player");
    SayAlive(player, 7);
    stream_t end{};
    end.event = "end";
    end.header.session = player.source().value;
    stream = player.source().value;
    player.Publish(bus::kStream, end);
    ASSERT_TRUE(Eventually([&] {
      camera_t camera{};
      camera.rig_name = "rig";
      player.Publish(bus::kCamera, camera);
      return before > 0 && keeper->kept() == 1;
    }));
    listener.Join();
  }
  bus::test::RunningBus late(On(url));
  std::atomic<int64_t> session = 0;
  late->Subscribe<camera_t>(bus::kCamera, [&](const camera_t& m) { cameras += m.rig_name == "rig" ? 1 : 0; });
  late->Subscribe<stream_t>(bus::kStream, [&](const stream_t& m) { session = m.header.session; });
  late.Start();
  keeper.Exit(7);
  EXPECT_TRUE(Eventually([&] { return cameras >= 2; })) << "not only once";
  EXPECT_TRUE(Eventually([&] { return session == stream; }));
  late.Join();
}

TEST(HistoryKeeper, PublishesNothingAfterStop) {
  const std::string url = PrivateUrl();
  bus::Bus lives(On(url), "viewer");  // used on the thread of the keeper's bus, which ends before it
  RunningKeeper keeper(url, testing::TempDir());
  {
    bus::Bus ends(On(url), "vo");
    SayAlive(ends, 7);
    for (int i = 0; i < 3; ++i) Say(ends, 100, i);
    ASSERT_TRUE(Eventually([&] { return keeper->kept() == 3; }));
  }
  LateListener late(url);
  keeper.bus().Post([&] {
    keeper->Stop();
    keeper->OnExit(7);
    keeper.bus().Post([&] { Say(lives, 200, 3); });
  });
  ASSERT_TRUE(Eventually([&] { return !late.poses().empty(); }));
  EXPECT_THAT(late.poses(), ElementsAre(Pair(200, 3)));
  EXPECT_EQ(keeper->said_again(), 0);
}

TEST(HistoryKeeper, LeavesNoFile) {
  std::string folder = testing::TempDir() + "keeper XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  bus::Bus bus(On(PrivateUrl()), "test");
  const HistoryKeeper keeper(bus, folder);
  EXPECT_EQ(keeper.problem(), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove(folder);
}

TEST(HistoryKeeper, UnwritableFolderIsReported) {
  const std::string url = PrivateUrl();
  RunningKeeper keeper(url, "/proc/no such folder");
  EXPECT_THAT(keeper->problem(), testing::HasSubstr("/proc/no such folder: "));
  bus::Bus says(On(url), "vo");
  SayAlive(says, 7);
  Say(says, 100, 0);
  EXPECT_TRUE(says.Flush(seconds(5))) << "it reads on";
  EXPECT_EQ(keeper->kept(), 0);
}

}  // namespace
}  // namespace plslam::launcher
