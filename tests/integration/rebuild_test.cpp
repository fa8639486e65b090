// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/bus/run_loop.h"
#include "plslam/camera_t.hpp"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/long_tests.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam {
namespace {

using test::FeatureWorld;
using test::Heard;
using test::RunWatcher;
using test::WholeRun;

/// The project's promise is about 1,000 keyframes.
int Keyframes() { return test::LongTests() ? 1000 : 150; }

RigCalibration RigOf(const StereoCamera& camera) {
  RigCalibration rig;
  rig.name = "made up";
  rig.rate_hz = 10.0;
  rig.left.width_px = camera.width_px;
  rig.left.height_px = camera.height_px;
  rig.left.fx_px = rig.left.fy_px = camera.f_px;
  rig.left.cx_px = camera.cx_px;
  rig.left.cy_px = camera.cy_px;
  rig.right = rig.left;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {camera.baseline_m, 0.0, 0.0});
  rig.baseline_m = camera.baseline_m;
  return rig;
}

/// A tracker that walks down a corridor, its keyframes in its history, and the processes that listen to it.
class Rebuild : public testing::Test {
 protected:
  Rebuild() : tracker_(On(watcher_.url()), "vo"), keyframes_(tracker_) {
    constexpr double kStep_m = 0.2;
    const int n = Keyframes() + 1;
    const FeatureWorld world = test::MakeCorridor(n * kStep_m + 8.0, 12.0, 3.0, 5);
    walk_ = test::MakeWalk(world, test::CorridorPath(n, kStep_m), {.with_ids = false});
    tracker_.Every(std::chrono::milliseconds(500),
                   [this] { tracker_.Publish(bus::kCamera, bus::ToMessage(RigOf(FeatureWorld::Camera()))); });
    map_ = std::make_unique<bus::MapUpdateSubscriber>(tracker_, [this](const MapUpdate& update) {
      const std::scoped_lock lock(mutex_);
      if (!maps_.empty() && maps_.back() == update.map_id) return;
      maps_.push_back(update.map_id);
      changed_.notify_all();
    });
    thread_ = std::thread([this] { tracker_.Run(); });
  }
  ~Rebuild() override {
    tracker_.Stop();
    thread_.join();
  }

  static bus::BusOptions On(const std::string& url) {
    bus::BusOptions options;
    options.url = url;
    return options;
  }

  void Say(int from, int to) {
    for (int i = from; i < to; ++i) {
      Keyframe& keyframe = walk_.keyframes[static_cast<size_t>(i)];
      keyframe.lockstep = true;
      keyframes_.Publish(keyframe);
    }
  }

  /// Returns the `n`-th map whose updates the tracker has received, consecutive updates of one map counted once.
  MapId AwaitMap(size_t n) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, test::Patience(std::chrono::seconds(60)), [&] { return maps_.size() >= n; }));
    return maps_.size() >= n ? maps_[n - 1] : MapId();
  }

  /// Publishes keyframes 0 to `n` of a session that belongs to `map`. If that is not the reset one, the tracker has
  /// received no map before the first keyframe.
  void PublishSession(SessionId session, const MapId& map, int n) {
    for (int i = 0; i < n; ++i) {
      Keyframe keyframe = walk_.keyframes[static_cast<size_t>(i)];
      keyframe.name = {session, i};
      keyframe.lockstep = true;
      if (i > 0 || map.n_replaced > 0) keyframe.map_id = map;
      keyframes_.Publish(keyframe);
    }
  }

  /// Sends `plslam reset`, and returns its exit code.
  int Reset() const {
    launcher::ChildProcess order(test::BinaryFolder() / "plslam", {"reset", "--url", watcher_.url()},
                                 run_.folder() / "reset.log");
    EXPECT_TRUE(WholeRun::WaitFor([&] { return order.Poll().has_value(); }));
    return order.Poll().value_or(launcher::ChildExit{-1}).code;
  }

  void Kill(launcher::ChildProcess& process) const {
    process.Signal(SIGKILL);
    ASSERT_TRUE(WholeRun::WaitFor([&] { return process.Poll().has_value(); }));
  }

  /// Waits until the map of this process has `n` keyframes of the session; returns the sessions in it.
  std::set<SessionId> SessionsAfter(const launcher::ChildProcess& mapper, SessionId session, size_t n) const {
    EXPECT_TRUE(watcher_.WaitFor([&](const Heard& heard) {
      const auto mapped = heard.mapped.find(session);
      return heard.IsMapOf(mapper.pid()) && mapped != heard.mapped.end() && mapped->second.size() >= n;
    }));
    std::set<SessionId> sessions;
    for (const auto& [in_map, numbers] : watcher_.Get().mapped) sessions.insert(in_map);
    return sessions;
  }

  std::unique_ptr<launcher::ChildProcess> Start(const std::string& program,
                                                std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--url", watcher_.url()});
    return std::make_unique<launcher::ChildProcess>(test::BinaryFolder() / program, arguments,
                                                    run_.folder() / (program + ".log"));
  }
  /// Waits once, and briefly, for a loop_process that has not been started yet.
  std::unique_ptr<launcher::ChildProcess> StartMapper(bool keeps_state = true) const {
    return Start("mapping_process", {"--set", "bus.partner_wait_s=2", "--set", "mapping.culling.redundant_share=1.01",
                                     "--set", "mapping.state_file=" + (keeps_state ? StateFile() : "")});
  }
  std::string StateFile() const { return (run_.folder() / "state.plmap").string(); }

  /// Returns the seconds until this process publishes that its map has so many keyframes; negative at the time limit.
  double Until(const std::string& process, const launcher::ChildProcess& child, const std::string& counter,
               int count) const {
    const double began_s = bus::NowS();
    const bool there = watcher_.WaitFor(
        [&](const Heard& heard) {
          const auto status = heard.status.find(process);
          return status != heard.status.end() && status->second.pid == child.pid() &&
                 heard.Counter(process, counter) >= count;
        },
        test::LongTests() ? 600 : 120);
    return there ? bus::NowS() - began_s : -1.0;
  }

  const WholeRun run_;
  RunWatcher watcher_;
  bus::Bus tracker_;
  bus::KeyframePublisher keyframes_;
  test::Walk walk_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<MapId> maps_;
  std::unique_ptr<bus::MapUpdateSubscriber> map_;
  std::thread thread_;
};

TEST_F(Rebuild, MapAndPlacesAreRebuiltInSeconds) {
  const int n = Keyframes();
  auto mapper = StartMapper();
  Say(0, n);
  ASSERT_GT(Until("mapping", *mapper, "map.keyframes", n), 0.0) << watcher_.Get().Counter("mapping", "map.keyframes");
  ASSERT_TRUE(std::filesystem::exists(StateFile()));

  mapper->Signal(SIGKILL);
  mapper = StartMapper();
  const double with_state_s = Until("mapping", *mapper, "map.keyframes", n);
  ASSERT_GT(with_state_s, 0.0);
  std::cout << n << " keyframes: mapping_process has its map rebuilt after " << with_state_s << " s\n";
  EXPECT_LT(with_state_s, 10.0);
  const Heard heard = watcher_.Get();
  ASSERT_EQ(heard.mapped.size(), 1U);
  EXPECT_EQ(heard.mapped.begin()->second.size(), static_cast<size_t>(n));

  // The newest keyframe is checked only when map and features are there: when loop_process is back.
  const auto loop = Start("loop_process", {});
  const double began_s = bus::NowS();
  ASSERT_TRUE(watcher_.WaitUntilReady("loop", loop->pid()));
  Say(n, n + 1);
  ASSERT_GT(Until("loop", *loop, "loop.keyframes", n + 1), 0.0);
  const double loop_s = bus::NowS() - began_s;
  std::cout << n << " keyframes: loop_process has its places rebuilt after " << loop_s << " s\n";
  EXPECT_LT(loop_s, 10.0);

  mapper->Signal(SIGKILL);
  while (!mapper->Poll()) std::this_thread::yield();
  std::filesystem::remove(StateFile());
  mapper = StartMapper();
  const double from_history_s = Until("mapping", *mapper, "map.keyframes", n + 1);
  ASSERT_GT(from_history_s, 0.0);
  std::cout << n << " keyframes: from the history alone the map is rebuilt after " << from_history_s << " s\n";
}

TEST_F(Rebuild, DamagedStateFallsBackToTheHistory) {
  std::ofstream(StateFile()) << "not a map";
  const auto mapper = StartMapper();
  Say(0, 3);
  EXPECT_GT(Until("mapping", *mapper, "map.keyframes", 3), 0.0);
  std::ifstream log(run_.folder() / "mapping_process.log");
  const std::string text{std::istreambuf_iterator<char>(log), {}};
  EXPECT_NE(text.find("rebuilding the map from the history: " + StateFile()), std::string::npos) << text;
}

constexpr SessionId kBefore = 7;
constexpr SessionId kAfter = 8;
constexpr SessionId kLast = 9;

/// A map with a session, which was then reset, and got another session.
class RebuildAfterReset : public Rebuild {
 protected:
  void Play(const launcher::ChildProcess& mapper) {
    PublishSession(kBefore, {}, 1);
    PublishSession(kBefore, AwaitMap(1), 5);
    ASSERT_EQ(SessionsAfter(mapper, kBefore, 5), std::set{kBefore});
    ASSERT_EQ(Reset(), 0);
    PublishSession(kAfter, AwaitMap(2), 5);
    ASSERT_EQ(SessionsAfter(mapper, kAfter, 5), std::set{kAfter});
  }
};

TEST_F(RebuildAfterReset, MapWithoutAStateStaysReset) {
  auto mapper = StartMapper(false);
  ASSERT_NO_FATAL_FAILURE(Play(*mapper));
  Kill(*mapper);
  mapper = StartMapper(false);
  EXPECT_EQ(SessionsAfter(*mapper, kAfter, 5), std::set{kAfter}) << "keyframes from before the reset";
}

TEST_F(RebuildAfterReset, DamagedStateLeavesTheMapReset) {
  auto mapper = StartMapper();
  ASSERT_NO_FATAL_FAILURE(Play(*mapper));
  Kill(*mapper);
  std::ofstream(StateFile()) << "not a map";
  mapper = StartMapper();
  EXPECT_EQ(SessionsAfter(*mapper, kAfter, 5), std::set{kAfter}) << "keyframes from before the reset";
}

TEST_F(RebuildAfterReset, MissingStateBeginsANewMap) {
  auto mapper = StartMapper();
  ASSERT_NO_FATAL_FAILURE(Play(*mapper));
  Kill(*mapper);
  std::filesystem::remove(StateFile());
  mapper = StartMapper();
  // Its map is published because the keyframes of the history belong to other maps.
  PublishSession(kLast, AwaitMap(3), 5);
  EXPECT_EQ(SessionsAfter(*mapper, kLast, 5), std::set{kLast}) << "keyframes from before the reset";
}

}  // namespace
}  // namespace plslam
