#include "tools/plslam/history_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "core/bus/process_usage.h"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "tools/plslam/bus_url.h"

namespace plslam {
namespace {

using std::chrono::seconds;
using testing::ElementsAre;
using testing::Pair;

bus::BusOptions On(const PrivatePort& port) {
  bus::BusOptions options;
  options.url = port.Url();
  return options;
}

/// A bus whose handlers run on a thread of its own.
class Runner {
 public:
  explicit Runner(const PrivatePort& port) : bus_(On(port), "test") {}
  ~Runner() {
    bus_.Stop();
    if (thread_.joinable()) thread_.join();
  }
  void Run() {
    thread_ = std::thread([this] { bus_.Run(); });
  }
  bus::Bus& bus() { return bus_; }

 private:
  bus::Bus bus_;
  std::thread thread_;
};

bool WaitFor(const std::function<bool()>& done) {
  const auto limit = std::chrono::steady_clock::now() + seconds(20);
  while (!done() && std::chrono::steady_clock::now() < limit)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return done();
}

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

/// What somebody hears who starts late.
class LateListener {
 public:
  explicit LateListener(const PrivatePort& port) : runner_(port) {
    runner_.bus().Subscribe<pose_t>(bus::kPose, [this](const pose_t& m) {
      const std::scoped_lock lock(mutex_);
      poses_.emplace_back(m.header.session, m.frame_id);
    });
    runner_.Run();
  }
  std::vector<std::pair<int64_t, int64_t>> poses() {
    const std::scoped_lock lock(mutex_);
    return poses_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<int64_t, int64_t>> poses_;
  Runner runner_;
};

TEST(HistoryKeeper, SaysInTheirPlaceWhatTheDeadHaveSaid) {
  const PrivatePort port;
  Runner runner(port);
  HistoryKeeper keeper(runner.bus(), testing::TempDir());
  runner.Run();
  {
    bus::Bus dies(On(port), "vo"), lives(On(port), "vo");
    SayAlive(dies, 7);
    SayAlive(lives, 8);
    for (int i = 0; i < 3; ++i) Say(dies, 100, i);
    Say(lives, 200, 3);
    ASSERT_TRUE(WaitFor([&] { return keeper.kept() == 4; }));
    EXPECT_EQ(keeper.said_again(), 0);
  }
  runner.bus().Post([&] { keeper.OnExit(7); });
  ASSERT_TRUE(WaitFor([&] { return keeper.said_again() == 3; }));
  LateListener late(port);
  ASSERT_TRUE(WaitFor([&] { return late.poses().size() >= 3; }));
  EXPECT_THAT(late.poses(), ElementsAre(Pair(100, 0), Pair(100, 1), Pair(100, 2)))
      << "of one that is not known to have died nothing is said";
  runner.bus().Post([&] { keeper.OnExit(7); });
  runner.bus().Post([&] { keeper.OnExit(8); });
  ASSERT_TRUE(WaitFor([&] { return late.poses().size() == 4; }));
  EXPECT_EQ(keeper.said_again(), 4) << "once";
  EXPECT_EQ(keeper.kept(), 4) << "what it says itself is not kept again";
}

TEST(HistoryKeeper, SaysNothingWhereAllProcessesEnd) {
  const PrivatePort port;
  Runner runner(port);
  HistoryKeeper keeper(runner.bus(), testing::TempDir());
  runner.Run();
  {
    bus::Bus ends(On(port), "vo");
    SayAlive(ends, 7);
    for (int i = 0; i < 3; ++i) Say(ends, 100, i);
    ASSERT_TRUE(WaitFor([&] { return keeper.kept() == 3; }));
  }
  LateListener late(port);
  bus::Bus lives(On(port), "viewer");
  runner.bus().Post([&] {
    keeper.Stop();
    keeper.OnExit(7);
    runner.bus().Post([&] { Say(lives, 200, 3); });
  });
  ASSERT_TRUE(WaitFor([&] { return !late.poses().empty(); }));
  EXPECT_THAT(late.poses(), ElementsAre(Pair(200, 3)));
  EXPECT_EQ(keeper.said_again(), 0);
}

TEST(HistoryKeeper, LeavesNoFileBehind) {
  std::string folder = testing::TempDir() + "keeper XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const PrivatePort port;
  Runner runner(port);
  const HistoryKeeper keeper(runner.bus(), folder);
  EXPECT_EQ(keeper.problem(), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove(folder);
}

TEST(HistoryKeeper, FolderThatCannotBeWrittenIsTold) {
  const PrivatePort port;
  Runner runner(port);
  HistoryKeeper keeper(runner.bus(), "/proc/no such folder");
  runner.Run();
  EXPECT_THAT(keeper.problem(), testing::HasSubstr("/proc/no such folder: "));
  bus::Bus says(On(port), "vo");
  SayAlive(says, 7);
  Say(says, 100, 0);
  EXPECT_TRUE(says.Flush(seconds(5))) << "it reads on";
  EXPECT_EQ(keeper.kept(), 0);
}

}  // namespace
}  // namespace plslam
