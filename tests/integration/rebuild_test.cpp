// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/keyframe_channel.h"
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

  std::unique_ptr<launcher::ChildProcess> Start(const std::string& program,
                                                std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--url", watcher_.url()});
    return std::make_unique<launcher::ChildProcess>(test::BinaryFolder() / program, arguments,
                                                    run_.folder() / (program + ".log"));
  }
  /// Waits once, and briefly, for a loop_process that has not been started yet.
  std::unique_ptr<launcher::ChildProcess> StartMapper() const {
    return Start("mapping_process", {"--set", "bus.partner_wait_s=2", "--set", "mapping.culling.redundant_share=1.01",
                                     "--set", "mapping.state_file=" + StateFile()});
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

}  // namespace
}  // namespace plslam
