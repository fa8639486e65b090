// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "core/io/maps/map_file.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tools/plslam/child_process.h"

namespace plslam {
namespace {

using test::Heard;
using test::RunWatcher;
using test::WholeRun;
using testing::HasSubstr;

/// A run of a small world, a listener, and a source of orders.
class Orders : public testing::Test {
 protected:
  static constexpr const char* kWorld = "synthetic:room?size=376x240&frames=120";
  static constexpr const char* kLongWorld = "synthetic:room?size=376x240&frames=200";

  /// At the pace of the data, so that there is time for orders on any machine.
  std::vector<std::string> Arguments(const char* world = kWorld) const {
    return {"run",        world,
            "--url",      watcher_.url(),
            "--pace",     "realtime",
            "--set",      "mapping.state_every=10",
            "--save-map", File("new.plmap").string()};
  }

  /// Returns the exit code of `plslam ORDER... --url URL`; its output is in `said_`.
  int Order(std::vector<std::string> order) {
    order.insert(order.end(), {"--url", watcher_.url()});
    const std::filesystem::path log = run_.folder() / "order.log";
    std::filesystem::remove(log);
    launcher::ChildProcess process(test::BinaryFolder() / "plslam", order, log);
    EXPECT_TRUE(WholeRun::WaitFor([&] { return process.Poll().has_value(); }));
    said_ = ReadText(log);
    return process.Poll().value_or(launcher::ChildExit{-1}).code;
  }

  /// Kills a process of the run, and waits until its replacement runs.
  void Kill(const std::string& name, const std::string& executable) {
    const pid_t pid = run_.PidOf(executable);
    ASSERT_GT(pid, 0);
    ASSERT_EQ(kill(pid, SIGKILL), 0);
    ASSERT_TRUE(WholeRun::WaitFor([&] {
      const pid_t next = run_.PidOf(executable);
      return next > 0 && next != pid && watcher_.WaitUntilReady(name, next, 1);
    })) << run_.Logs();
  }

  bool HasSessions(size_t n) const {
    return watcher_.WaitFor([n](const Heard& heard) { return heard.poses.size() >= n; });
  }

  std::set<int64_t> SessionsOf(const std::filesystem::path& map) const {
    std::set<int64_t> sessions;
    const StoredMap stored = ReadMapFile(map.string());
    for (const auto& [id, keyframe] : stored.map.keyframes()) sessions.insert(keyframe.session);
    return sessions;
  }

  std::filesystem::path File(const std::string& name) const { return run_.folder() / name; }

  WholeRun run_;
  RunWatcher watcher_;
  std::string said_;
};

TEST_F(Orders, PausedPlayerStaysPausedAfterAKill) {
  WholeRun reference;
  ASSERT_EQ(reference.Run({"run", kWorld}), 0) << reference.Logs();

  run_.Start({"run", kWorld, "--url", watcher_.url()});
  ASSERT_TRUE(watcher_.WaitForFrame(10));
  ASSERT_EQ(Order({"pause"}), 0) << said_;
  Kill("player", "player");
  Kill("vo", "vo_process");
  // The frames after the last keyframe are sent again, and no others.
  const int64_t newest = watcher_.Get().newest_frame;
  EXPECT_LT(newest, 119);
  EXPECT_FALSE(watcher_.WaitForFrame(newest + 1, 3));
  ASSERT_EQ(Order({"resume"}), 0) << said_;
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
  EXPECT_EQ(run_.Read("trajectory.tum"), reference.Read("trajectory.tum"));
}

TEST_F(Orders, ResetMapSurvivesAMapperKill) {
  run_.Start(Arguments());
  ASSERT_TRUE(watcher_.WaitForFrame(30));
  ASSERT_EQ(Order({"reset"}), 0) << said_;
  ASSERT_TRUE(HasSessions(2)) << run_.Logs();
  Kill("mapping", "mapping_process");
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
  EXPECT_EQ(watcher_.Get().poses.size(), 2U);
  EXPECT_EQ(SessionsOf(File("new.plmap")), std::set{watcher_.Get().poses.rbegin()->first});
}

TEST_F(Orders, LoadContinuesInASavedMap) {
  WholeRun before;
  ASSERT_EQ(before.Run({"run", kWorld, "--save-map", File("old.plmap").string()}), 0) << before.Logs();
  std::ofstream(File("none.plmap")) << "not a map";
  run_.Start(Arguments());
  ASSERT_TRUE(watcher_.WaitForFrame(20));
  EXPECT_EQ(Order({"load", File("none.plmap").string()}), 1);
  EXPECT_THAT(said_, HasSubstr("none.plmap"));
  ASSERT_EQ(Order({"pause"}), 0) << said_;
  EXPECT_EQ(watcher_.Get().poses.size(), 1U);
  ASSERT_EQ(Order({"load", File("old.plmap").string()}), 0) << said_;
  ASSERT_EQ(Order({"resume"}), 0) << said_;
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
  const std::set<int64_t> old = SessionsOf(File("old.plmap"));
  std::set<int64_t> expected = old;
  expected.insert(watcher_.Get().poses.rbegin()->first);
  EXPECT_EQ(SessionsOf(File("new.plmap")), expected);
}

TEST_F(Orders, LocaliseOnFreezesTheMapUntilOff) {
  run_.Start(Arguments(kLongWorld));
  ASSERT_TRUE(watcher_.WaitForFrame(15));
  ASSERT_EQ(Order({"localise", "on"}), 0) << said_;
  const auto mapped = watcher_.Get().mapped;
  const int64_t newest = watcher_.Get().newest_frame;
  Kill("mapping", "mapping_process");
  ASSERT_TRUE(watcher_.WaitForFrame(newest + 20)) << run_.Logs();
  ASSERT_EQ(Order({"pause"}), 0) << said_;
  EXPECT_EQ(watcher_.Get().mapped, mapped);
  EXPECT_EQ(watcher_.Get().poses.size(), 1U);
  ASSERT_LT(watcher_.Get().newest_frame, 170) << "too late for what follows";
  ASSERT_EQ(Order({"localise", "off"}), 0) << said_;
  ASSERT_EQ(Order({"resume"}), 0) << said_;
  ASSERT_EQ(run_.Wait(), 0) << run_.Logs();
  EXPECT_EQ(watcher_.Get().poses.size(), 2U) << "keyframes that were not sent are no gap in a session";
  EXPECT_EQ(SessionsOf(File("new.plmap")).size(), 2U);
  EXPECT_EQ(watcher_.Get().lost_frames, 0);
}

TEST_F(Orders, OrderWithoutReceiverFails) {
  EXPECT_EQ(Order({"pause"}), 1);
  EXPECT_THAT(said_, HasSubstr("no process 'player' or 'camera' was found"));
  EXPECT_EQ(Order({"localise", "perhaps"}), 1);
}

}  // namespace
}  // namespace plslam
