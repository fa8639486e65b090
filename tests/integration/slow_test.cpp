// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/bus/run_loop.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/long_tests.h"

namespace plslam {
namespace {

using test::Heard;
using test::RunWatcher;
using test::WholeRun;

/// Lets a process run for a tenth of the time, until the end of the scope.
class TenPercent {
 public:
  explicit TenPercent(pid_t pid) : pid_(pid), thread_([this] { Throttle(); }) {}
  ~TenPercent() {
    stop_ = true;
    thread_.join();
    kill(pid_, SIGCONT);
  }
  TenPercent(const TenPercent&) = delete;
  TenPercent& operator=(const TenPercent&) = delete;

 private:
  void Throttle() const {
    while (!stop_) {
      kill(pid_, SIGSTOP);
      std::this_thread::sleep_for(std::chrono::milliseconds(90));
      kill(pid_, SIGCONT);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  pid_t pid_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A stream that the tracker can keep up with, all other stages beside it on two cores.
#ifdef PLSLAM_SANITIZED
constexpr int kRate_Hz = 2;
#else
constexpr int kRate_Hz = 10;
#endif

/// Times between the poses of one frame and the next, sorted.
std::vector<double> Gaps_s(const Heard& heard, int64_t from, int64_t to) {
  std::vector<double> gaps;
  double last = 0.0;
  for (const auto& [frame, at_s] : heard.pose_at_s) {
    if (frame < from || frame > to) continue;
    if (last > 0.0) gaps.push_back(at_s - last);
    last = at_s;
  }
  std::sort(gaps.begin(), gaps.end());
  return gaps;
}

class SlowStage : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(SlowStage, DoesNotDelayLivePoses) {
  const char* const name = GetParam().first;
  const char* const executable = GetParam().second;
  if (name != std::string("mapping")) {
    PLSLAM_REQUIRE_LONG_TESTS();
  }
  const int frames = test::LongTests() ? 400 : 50;
  RunWatcher watcher;
  WholeRun run;
  run.Start({"run", fmt::format("synthetic:room?size=320x200&frames={}&rate={}", frames, kRate_Hz), "--pace",
             "realtime", "--url", watcher.url()});
  ASSERT_TRUE(watcher.WaitForFrame(10)) << run.Logs();
  {
    const pid_t pid = run.PidOf(executable);
    ASSERT_GT(pid, 0);
    const TenPercent throttle(pid);
    ASSERT_TRUE(watcher.WaitForFrame(frames - 10, frames)) << run.Logs();
  }
  ASSERT_EQ(run.Wait(), 0) << run.Logs();
  const Heard heard = watcher.Get();
  const std::vector<double> gaps = Gaps_s(heard, 10, frames - 10);
  ASSERT_GT(gaps.size(), 10U);
  const double median = gaps[gaps.size() / 2], worst = gaps.back();
  const nlohmann::json summary = run.Summary();
  const double queue = summary["processes"][name]["longest_queue"];
  std::cout << name << " at 10 %: poses every " << median << " s, at worst " << worst << " s; "
            << summary["skipped_frames"] << " of " << frames << " frames skipped; longest queue " << queue << '\n';
  EXPECT_LT(median, 1.3 / kRate_Hz);
  EXPECT_LT(worst, 10.0 / kRate_Hz) << "a pose is never older than that";
  EXPECT_LT(queue, 100.0);
  EXPECT_EQ(summary["processes"][name]["restarts"], 0);
}

INSTANTIATE_TEST_SUITE_P(Stages, SlowStage,
                         testing::Values(std::pair("mapping", "mapping_process"), std::pair("loop", "loop_process")),
                         [](const auto& stage) { return std::string(stage.param.first); });

TEST(SlowTracker, SkipsAndReportsFramesWithoutGrowth) {
  // More frames than can be tracked in a tenth of the time, however fast the machine is.
  const int frames = test::LongTests() ? 1600 : 160;
  RunWatcher watcher;
  WholeRun run;
  run.Start({"run", fmt::format("synthetic:room?size=320x200&frames={}&rate=40", frames), "--pace", "realtime",
             "--url", watcher.url()});
  ASSERT_TRUE(watcher.WaitForFrame(5)) << run.Logs();
  {
    const TenPercent throttle(run.PidOf("vo_process"));
    ASSERT_TRUE(
        watcher.WaitFor([&](const Heard& heard) { return heard.Counter("player", "frames.sent") >= frames; }, 120))
        << run.Logs();
  }
  ASSERT_EQ(run.Wait(), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  std::cout << "tracker at 10 %: " << summary["frames"] << " poses, " << summary["skipped_frames"] << " skipped\n";
  EXPECT_GT(summary["skipped_frames"], 0);
  EXPECT_EQ(summary["frames"].get<int>() + summary["skipped_frames"].get<int>(), frames);
}

/// The tracker does not wait for exited processes: poses of every frame arrive while a process whose results they do
/// not need is missing.
class Missing : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(Missing, PosesContinueWithoutAKilledProcess) {
  const char* const name = GetParam().first;
  const char* const executable = GetParam().second;
  const int frames = 40;
  const WholeRun folder;
  const RunWatcher watcher;
  const auto start = [&](const std::string& program, std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--url", watcher.url()});
    return std::make_unique<launcher::ChildProcess>(test::BinaryFolder() / program, arguments,
                                                    folder.folder() / (program + ".log"));
  };
  std::map<std::string, std::unique_ptr<launcher::ChildProcess>> processes;
  processes["viewer_headless"] = start("viewer_headless", {"--out", folder.out().string(), "--quiet"});
  processes["mapping_process"] = start("mapping_process", {"--set", "bus.partner_wait_s=1"});
  processes["loop_process"] = start("loop_process", {});
  processes["vo_process"] = start("vo_process", {"--set", "bus.partner_wait_s=1"});
  for (const char* each : {"viewer", "mapping", "loop", "vo"}) {
    ASSERT_TRUE(watcher.WaitFor([&](const Heard& heard) { return heard.status.contains(each); })) << each;
  }
  processes["player"] = start("player", {fmt::format("synthetic:room?size=320x200&frames={}", frames)});
  ASSERT_TRUE(watcher.WaitForFrame(15));
  processes[executable]->Signal(SIGKILL);
  ASSERT_TRUE(WholeRun::WaitFor([&] { return processes[executable]->Poll().has_value(); }));
  EXPECT_TRUE(watcher.WaitForFrame(frames - 1))
      << name << " is gone, and no pose came behind frame " << watcher.Get().newest_frame;
  const Heard heard = watcher.Get();
  EXPECT_EQ(heard.frames.size(), static_cast<size_t>(frames));
  EXPECT_EQ(heard.lost_frames, 0);
  for (auto& [program, process] : processes) process->Signal(SIGINT);
  for (auto& [program, started] : processes) {
    if (program == executable) continue;
    launcher::ChildProcess* process = started.get();
    EXPECT_TRUE(WholeRun::WaitFor([&] { return process->Poll().has_value(); })) << program;
    EXPECT_EQ(process->Poll()->code, 0) << program;
  }
}

INSTANTIATE_TEST_SUITE_P(Partners, Missing,
                         testing::Values(std::pair("mapping", "mapping_process"), std::pair("loop", "loop_process"),
                                         std::pair("viewer", "viewer_headless")),
                         [](const auto& partner) { return std::string(partner.param.first); });

}  // namespace
}  // namespace plslam
