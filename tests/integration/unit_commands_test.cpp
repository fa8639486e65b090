// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/installed_services.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/stored_map_bytes.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/long_tests.h"
#include "tests/support/sanitized.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"

namespace plslam {
namespace {

using test::Heard;
using test::InstalledServices;
using test::RunWatcher;
using test::WholeRun;
using testing::HasSubstr;

/// Names of services in the order in which they are stopped or started.
using Order = std::vector<std::string>;

/// Services whose order matters, sorted.
const Order kStateful = {"loop", "mapping", "vo"};

/// Keyframes by session, as in `Heard`.
using Keyframes = std::map<SessionId, std::set<int64_t>>;

constexpr int kFrames = 80;

/// A robot's /etc/plslam/front.yaml. Redundant keyframes stay in the map, so that a missing keyframe has been lost.
/// Processes wait for a stopped one however busy the machine is.
std::string Configuration(const std::string& url, int frames) {
  return fmt::format(
      "bus:\n  url: \"{}\"\n  partner_wait_s: 120\n"
      "mapping:\n  culling:\n    redundant_share: 1.01\n"
      "player:\n  dataset: \"synthetic:room?size=376x240&frames={}\"\n  exit: true\n",
      url, frames);
}

std::string Text(const Keyframes& keyframes) {
  std::string text;
  for (const auto& [session, numbers] : keyframes) text += fmt::format("session {}: {}\n", session, numbers);
  return text;
}

bool Includes(const Keyframes& all, const Keyframes& part) {
  return std::ranges::all_of(part, [&](const auto& session) {
    const auto found = all.find(session.first);
    return found != all.end() && std::ranges::includes(found->second, session.second);
  });
}

/// One stop and start of the services during a run.
struct Moment {
  Order stops;
  Order starts;
  std::set<std::string> killed;  ///< instead of stopped
  /// As `systemctl stop` of the target does, instead of one service after the other.
  bool at_once = false;
  int frames_later = 1;  ///< after the previous moment
  int ms_later = 0;      ///< after that frame
};

std::string Text(const Moment& m) {
  return fmt::format("stop {}{}{}, start {}", fmt::join(m.stops, " "), m.at_once ? " at once" : "",
                     m.killed.empty() ? "" : fmt::format(", {} killed", fmt::join(m.killed, " ")),
                     fmt::join(m.starts, " "));
}

std::vector<Order> Permutations(Order names) {
  std::vector<Order> all;
  do {
    all.push_back(names);
  } while (std::ranges::next_permutation(names).found);
  return all;
}

/// Each order of stops once, with the orders of starts in another sequence. The viewer has a random place.
std::vector<Moment> RandomMoments(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Order> stops = Permutations(kStateful), starts = stops;
  std::shuffle(stops.begin(), stops.end(), random);
  std::shuffle(starts.begin(), starts.end(), random);
  const auto with_viewer = [&random](Order order) {
    order.insert(order.begin() + static_cast<int>(random() % (order.size() + 1)), "viewer");
    return order;
  };
  const auto n = static_cast<unsigned>(stops.size());
  std::vector<Moment> moments;
  for (unsigned i = 0; i < n; ++i) {
    Moment m;
    m.stops = with_viewer(stops[i]);
    m.starts = with_viewer(starts[i]);
    m.at_once = random() % 3 == 0;
    // A mapping_process that is killed while vo_process is away may lose the newest keyframe, and a killed vo_process
    // the newest frames: neither is an orderly stop.
    if (random() % 3 == 0) m.killed = {random() % 2 == 0 ? "loop" : "viewer"};
    m.frames_later = 1 + static_cast<int>(random() % (kFrames / (n + 1)));
    m.ms_later = static_cast<int>(random() % 100);
    moments.push_back(std::move(m));
  }
  return moments;
}

/// Poses and map of a run, for comparison with another one.
struct Result {
  std::vector<std::vector<uint8_t>> poses;  ///< by frame, as published
  std::vector<uint8_t> map;
};

std::vector<size_t> FramesThatDiffer(const std::vector<std::vector<uint8_t>>& a,
                                     const std::vector<std::vector<uint8_t>>& b) {
  std::vector<size_t> frames;
  for (size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    if (i >= a.size() || i >= b.size() || a[i] != b[i]) frames.push_back(i);
  }
  return frames;
}

/// The installed units of one robot on a private bus.
class ServicesOfARobot {
 public:
  explicit ServicesOfARobot(int frames) : services_(folder(), "front", Configuration(watcher_.url(), frames)) {}

  std::filesystem::path folder() const { return run_.folder(); }
  InstalledServices& services() { return services_; }
  const RunWatcher& watcher() const { return watcher_; }

  /// Starts a service, and waits until it is ready.
  void Start(const std::string& name) {
    services_.Start(name);
    ASSERT_TRUE(watcher_.WaitUntilReady(name, services_.pid(name))) << name << ":\n" << services_.Log(name);
  }
  void StartAll(const Order& names) {
    for (const std::string& name : names) ASSERT_NO_FATAL_FAILURE(Start(name));
  }
  void Stop(const std::string& name) {
    services_.Signal(name, SIGTERM);
    EXPECT_EQ(services_.ExitCode(name), 0) << name << ":\n" << services_.Log(name);
  }
  void Stop(const Moment& m) {
    const auto expect_end = [&](const std::string& name) {
      EXPECT_EQ(services_.ExitCode(name), m.killed.contains(name) ? 128 + SIGKILL : 0) << name << ":\n"
                                                                                       << services_.Log(name);
    };
    for (const std::string& name : m.stops) {
      services_.Signal(name, m.killed.contains(name) ? SIGKILL : SIGTERM);
      if (!m.at_once) expect_end(name);
    }
    if (m.at_once) std::ranges::for_each(m.stops, expect_end);
  }

  /// Runs `plslam ARGUMENTS...` on the bus. Returns its exit code; the output is in `output()`.
  int Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--url", watcher_.url()});
    std::filesystem::remove(folder() / "order.log");
    launcher::ChildProcess order(test::BinaryFolder() / "plslam", arguments, folder() / "order.log");
    EXPECT_TRUE(WholeRun::WaitFor([&] { return order.Poll().has_value(); }));
    return order.Poll().value_or(launcher::ChildExit{-1}).code;
  }
  std::string output() const { return ReadText(folder() / "order.log"); }

  bool LogWillHave(const std::string& name, const std::string& text) const {
    return WholeRun::WaitFor([&] { return services_.Log(name).find(text) != std::string::npos; });
  }

  /// Waits until the running mapping_process has published a map with these keyframes.
  bool HasMapWith(const Keyframes& keyframes) const {
    return watcher_.WaitFor(
        [&](const Heard& heard) {
          return heard.IsMapOf(services_.pid("mapping")) && Includes(heard.mapped, keyframes);
        },
        20);
  }

 private:
  const WholeRun run_;
  const RunWatcher watcher_;
  InstalledServices services_;
};

/// The invariant: each keyframe that was in a published map before the stop, and thereby acknowledged, is in the map of
/// the next mapping_process; that process says that it continues the map in its StateDirectory.
void StopAndStart(const Moment& m, ServicesOfARobot* robot) {
  robot->Stop(m);
  Keyframes acknowledged = robot->watcher().Get().mapped;
  // The state is written after the update, so that a killed mapping_process may lack the newest keyframe.
  for (auto& [session, numbers] : acknowledged) {
    if (m.killed.contains("mapping") && numbers.size() > 1) numbers.erase(std::prev(numbers.end()));
  }
  ASSERT_NO_FATAL_FAILURE(robot->StartAll(m.starts));
  const std::string state = (robot->services().StateFolder("mapping") / "state").string();
  EXPECT_TRUE(robot->HasMapWith(acknowledged))
      << "acknowledged:\n"
      << Text(acknowledged) << "after the restart:\n"
      << Text(robot->watcher().Get().mapped) << robot->services().Log("mapping");
  EXPECT_TRUE(robot->LogWillHave("mapping", "continuing the map in " + state)) << robot->services().Log("mapping");
}

/// Plays the dataset with the services stopped at these moments, and checks that the result is complete.
Result Play(const std::vector<Moment>& moments) {
  ServicesOfARobot robot(kFrames);
  const RunWatcher& watcher = robot.watcher();
  robot.StartAll({"mapping", "loop", "vo", "viewer", "player"});
  EXPECT_TRUE(watcher.WaitFor([](const Heard& heard) { return !heard.mapped.empty(); })) << robot.services().Logs();
  if (testing::Test::HasFailure()) return {};
  for (const Moment& m : moments) {
    const int64_t frame = std::min<int64_t>(watcher.Get().newest_frame + m.frames_later, kFrames - 2);
    EXPECT_TRUE(watcher.WaitForFrame(frame)) << "standstill before frame " << frame << '\n'
                                             << robot.services().Logs();
    if (testing::Test::HasFailure()) return {};
    std::this_thread::sleep_for(std::chrono::milliseconds(m.ms_later));
    const std::string moment = fmt::format("frame {}: {}", watcher.Get().newest_frame, Text(m));
    std::cout << moment << std::endl;
    SCOPED_TRACE(moment);
    StopAndStart(m, &robot);
    if (testing::Test::HasFailure()) return {};
  }
  // The player itself waits longer for readers that were killed (`bus.give_up_s`).
  const auto is_finished = [&](const Heard& heard) {
    const auto vo = heard.status.find("vo");
    return vo != heard.status.end() && vo->second.pid == robot.services().pid("vo") && vo->second.state == "finished";
  };
  EXPECT_TRUE(watcher.WaitFor(is_finished)) << "newest frame " << watcher.Get().newest_frame << '\n'
                                            << robot.services().Logs();
  if (testing::Test::HasFailure()) return {};
  const std::filesystem::path map = robot.services().StateFolder("mapping") / "house.plmap";
  EXPECT_EQ(robot.Run({"save", map.string()}), 0) << robot.output();

  const Heard heard = watcher.Get();
  EXPECT_EQ(heard.frames.size(), static_cast<size_t>(kFrames));
  EXPECT_EQ(heard.poses_said_otherwise, 0) << "of " << heard.poses_said_again << " that were resent";
  EXPECT_EQ(heard.poses.size(), 1U) << "trackers continue the session";
  EXPECT_TRUE(Includes(heard.mapped, heard.keyframes)) << Text(heard.keyframes) << "in the map:\n"
                                                       << Text(heard.mapped);
  for (const char* name : {"player", "vo", "mapping", "loop", "viewer"}) {
    if (robot.services().Runs(name)) robot.Stop(name);
  }
  if (testing::Test::HasFailure()) return {};
  Result result{.poses = {}, .map = test::BytesWithoutName(map)};
  for (const auto& [frame, pose] : heard.poses.begin()->second) result.poses.push_back(pose);
  return result;
}

constexpr unsigned kFirstSeed = 1;
constexpr unsigned kSeeds = 20;

/// By seed: with all seeds there are 20 random moments for each order of stops, and for each order of starts.
class UnitCommands : public testing::TestWithParam<unsigned> {};

TEST_P(UnitCommands, StopsInAnyOrderKeepTheMap) {
  if (GetParam() != kFirstSeed && !test::LongTests()) GTEST_SKIP() << "one seed is enough: PLSLAM_LONG_TESTS";
  const Result undisturbed = Play({});
  ASSERT_FALSE(HasFailure());
  const Result stopped = Play(RandomMoments(GetParam()));
  ASSERT_FALSE(HasFailure());
  // Not promised: services that are stopped together may continue with other timing of loops and commits.
  const std::vector<size_t> differ = FramesThatDiffer(stopped.poses, undisturbed.poses);
  std::cout << fmt::format("{} of {} poses differ from those of an undisturbed run; the map {}\n", differ.size(),
                           stopped.poses.size(), stopped.map == undisturbed.map ? "does not" : "does, too");
}

INSTANTIATE_TEST_SUITE_P(Random, UnitCommands, testing::Range(kFirstSeed, kFirstSeed + kSeeds),
                         testing::PrintToStringParamName());

TEST(UnitState, PowerCutKeepsTheMap) {
  ServicesOfARobot robot(kFrames);
  ASSERT_NO_FATAL_FAILURE(robot.StartAll({"mapping", "loop", "vo", "viewer", "player"}));
  ASSERT_TRUE(robot.watcher().WaitForFrame(kFrames / 2)) << robot.services().Logs();
  Moment m;
  m.stops = {"mapping", "vo", "loop", "viewer"};
  m.starts = {"viewer", "vo", "loop", "mapping"};
  m.killed = {m.stops.begin(), m.stops.end()};
  m.at_once = true;
  StopAndStart(m, &robot);
}

TEST(UnitState, ResetOrMissingStateBeginsANewMap) {
  ServicesOfARobot robot(20);
  const auto log = [&] { return robot.services().Log("mapping"); };
  ASSERT_NO_FATAL_FAILURE(robot.StartAll({"mapping", "loop", "vo", "player"}));
  ASSERT_EQ(robot.services().ExitCode("player"), 0) << robot.services().Log("player");
  const std::filesystem::path state = robot.services().StateFolder("mapping") / "state";
  EXPECT_THAT(log(), HasSubstr("beginning a new map: there is no " + state.string()));
  ASSERT_FALSE(robot.watcher().Get().mapped.empty());

  ASSERT_EQ(robot.Run({"reset"}), 0) << robot.output();
  for (const std::string& name : kStateful) robot.Stop(name);
  ASSERT_NO_FATAL_FAILURE(robot.StartAll(kStateful));
  EXPECT_TRUE(robot.LogWillHave("mapping", "beginning a new map")) << log();

  ASSERT_NO_FATAL_FAILURE(robot.Start("player"));
  ASSERT_EQ(robot.services().ExitCode("player"), 0) << robot.services().Log("player");
  for (const std::string& name : kStateful) robot.Stop(name);
  std::filesystem::remove(state);
  ASSERT_NO_FATAL_FAILURE(robot.StartAll(kStateful));
  ASSERT_NO_FATAL_FAILURE(robot.Start("player"));
  ASSERT_EQ(robot.services().ExitCode("player"), 0) << robot.services().Log("player");
  EXPECT_THAT(log(), HasSubstr("beginning a new map: there is no " + state.string()));
  for (const std::string& name : kStateful) robot.Stop(name);
}

/// Two instances without a prefix of their own on one bus.
TEST(UnitState, SecondInstanceOnABusRefusesToStart) {
  ServicesOfARobot front(20);
  InstalledServices rear(front.folder(), "rear", Configuration(front.watcher().url(), 20));
  for (const char* name : {"mapping", "loop", "vo", "viewer"}) {
    ASSERT_NO_FATAL_FAILURE(front.Start(name));
    rear.Start(name);
    EXPECT_EQ(rear.ExitCode(name), 1) << name;
    EXPECT_THAT(rear.Log(name), HasSubstr(fmt::format("another {} is running on this bus: process {}", name,
                                                      front.services().pid(name))));
    EXPECT_THAT(rear.Log(name), HasSubstr("--prefix"));
    EXPECT_TRUE(front.services().Runs(name)) << "the first one continues";
  }
  for (const char* name : {"vo", "mapping", "loop", "viewer"}) front.Stop(name);
}

}  // namespace
}  // namespace plslam
