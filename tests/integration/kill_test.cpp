#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/long_tests.h"

namespace plslam {
namespace {

using test::Heard;
using test::RunWatcher;
using test::WholeRun;

struct Victim {
  const char* name;  ///< in the summary and in its status
  const char* executable;
};
constexpr std::array<Victim, 5> kVictims{{{"player", "player"},
                                          {"vo", "vo_process"},
                                          {"mapping", "mapping_process"},
                                          {"loop", "loop_process"},
                                          {"viewer", "viewer_headless"}}};

/// How much of it.
struct Extent {
  int kills = 5;
  int frames = 200;
};

Extent ExtentOfTheRun() { return test::LongTests() ? Extent{50, 1600} : Extent{}; }

std::vector<std::string> Arguments(const std::string& url, int frames) {
  // Keyframes are never culled, so that one that is missing has been lost.
  return {"run",
          fmt::format("synthetic:room?size=376x240&frames={}&loops={}", frames, std::max(1, frames / 200)),
          "--url",
          url,
          "--set",
          "mapping.culling.redundant_share=1.01",
          "--max-restarts",
          "100"};
}

/// Kills one after the other in a random order, each as soon as a number of frames has passed and the last one is back; every
/// fourth time two at a time. Returns how many died, by name.
std::map<std::string, int> KillAtRandom(const WholeRun& run, const RunWatcher& watcher, const Extent& extent) {
  std::mt19937 random(7);
  std::map<std::string, int> killed;
  std::array<int, kVictims.size()> order{};
  std::iota(order.begin(), order.end(), 0);
  const int stride = extent.frames / (extent.kills + 2);
  int64_t frame = 0;
  for (int done = 0; done < extent.kills;) {
    frame = std::max<int64_t>(frame, watcher.Get().newest_frame) + 1 + static_cast<int>(random() % stride);
    if (!watcher.WaitForFrame(std::min<int64_t>(frame, extent.frames - 20), 120)) {
      ADD_FAILURE() << "no progress behind frame " << watcher.Get().newest_frame << '\n' << run.Logs();
      return killed;
    }
    // Each kind in turn, in an order that changes.
    if (done % static_cast<int>(order.size()) == 0) std::shuffle(order.begin(), order.end(), random);
    const int at_once = done % 4 == 3 && done + 1 < extent.kills ? 2 : 1;
    std::vector<std::pair<Victim, pid_t>> dead;
    for (int i = 0; i < at_once; ++i, ++done) {
      const Victim& victim = kVictims[static_cast<size_t>(order[static_cast<size_t>(done) % order.size()])];
      const pid_t pid = run.PidOf(victim.executable);
      if (pid < 0 || kill(pid, SIGKILL) != 0) {
        ADD_FAILURE() << victim.name << " does not run";
        continue;
      }
      ++killed[victim.name];
      dead.emplace_back(victim, pid);
      std::cout << "frame " << watcher.Get().newest_frame << ": " << victim.name << " killed\n";
    }
    for (const auto& [victim, killed_pid] : dead) {
      const bool back = WholeRun::WaitFor([&, &victim = victim, &killed_pid = killed_pid] {
        const pid_t pid = run.PidOf(victim.executable);
        return pid > 0 && pid != killed_pid && watcher.WaitUntilReady(victim.name, pid, 1);
      });
      if (!back) ADD_FAILURE() << victim.name << " is not back";
    }
  }
  return killed;
}

/// Everything of which a process had said that it is a keyframe is in the map.
void ExpectAllKeyframes(const Heard& heard) {
  for (const auto& [session, keyframes] : heard.keyframes) {
    const auto mapped = heard.mapped.find(session);
    ASSERT_NE(mapped, heard.mapped.end()) << "nothing of session " << session << " with " << keyframes.size();
    EXPECT_TRUE(std::includes(mapped->second.begin(), mapped->second.end(), keyframes.begin(), keyframes.end()))
        << keyframes.size() << " keyframes heard, " << mapped->second.size() << " in the map";
    EXPECT_EQ(*mapped->second.rbegin() + 1, static_cast<int64_t>(mapped->second.size())) << "gap-free";
  }
}

TEST(Kills, RandomOnesLoseNoKeyframeAndCostNoAccuracy) {
  const Extent extent = ExtentOfTheRun();
  RunWatcher quiet_watcher, watcher;
  WholeRun undisturbed, run;
  ASSERT_EQ(undisturbed.Run(Arguments(quiet_watcher.url(), extent.frames)), 0) << undisturbed.Logs();
  EXPECT_EQ(quiet_watcher.Get().poses_said_again, 0) << "nobody has died";
  run.Start(Arguments(watcher.url(), extent.frames));
  const std::map<std::string, int> killed = KillAtRandom(run, watcher, extent);
  ASSERT_EQ(run.Wait(600), 0) << run.Logs();

  const nlohmann::json summary = run.Summary();
  const Heard heard = watcher.Get();
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["frames"], extent.frames);
  EXPECT_EQ(heard.frames.size(), static_cast<size_t>(extent.frames));
  for (const auto& [name, n] : killed) {
    const nlohmann::json& process = summary["processes"][name];
    EXPECT_EQ(process["restarts"], n) << name;
    EXPECT_LT(process["slowest_restart_s"], 2.0) << name;
    std::cout << name << ": killed " << n << " times, back within " << process["slowest_restart_s"] << " s\n";
  }
  for (const auto& [session, frames] : heard.poses) {
    for (const auto& [frame, n] : frames) EXPECT_EQ(n, 1) << "frame " << frame;
  }
  EXPECT_EQ(heard.publishers_of_poses.size(), static_cast<size_t>(1 + (killed.contains("vo") ? killed.at("vo") : 0)));
  ExpectAllKeyframes(heard);
  const double ate_m = summary["accuracy"]["ate_m"], undisturbed_m = undisturbed.Summary()["accuracy"]["ate_m"];
  std::cout << "ATE " << ate_m << " m, undisturbed " << undisturbed_m << " m; " << heard.poses.size() << " sessions, "
            << summary["map"]["keyframes"] << " keyframes, undisturbed " << undisturbed.Summary()["map"]["keyframes"]
            << '\n';
  EXPECT_LT(ate_m, 1.05 * undisturbed_m + 0.0005);
  const std::string path = run.Read("trajectory.tum");
  EXPECT_GE(std::count(path.begin(), path.end(), '\n'), extent.frames - killed.size());
}

}  // namespace
}  // namespace plslam
