// SPDX-License-Identifier: BSD-3-Clause
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

#include "core/bus/run_loop.h"
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

constexpr unsigned kFirstSeed = 7;

/// Number of kills and frames of the test.
struct Extent {
  int kills = 5;
  int frames = 200;
};

Extent ExtentOfTheRun() { return test::LongTests() ? Extent{50, 1600} : Extent{}; }

std::vector<std::string> Arguments(const std::string& url, int frames) {
  // Keyframes are never culled, so that one that is missing has been lost.
  return {"run",
          fmt::format("synthetic:room?size=376x240&imu=200&frames={}&loops={}", frames, std::max(1, frames / 200)),
          "--url",
          url,
          "--set",
          "mapping.culling.redundant_share=1.01",
          "--set",
          "mapping.state_every=10",
          "--max-restarts",
          "100"};
}

/// A killed process, and its replacement.
struct Death {
  Victim victim;
  double at_s = 0.0;  ///< of the steady clock
  pid_t killed = -1;
  pid_t replacement = -1;
};

/// Waits for the replacement.
bool IsReplaced(const WholeRun& run, const RunWatcher& watcher, Death& death) {
  return WholeRun::WaitFor([&] {
    death.replacement = run.PidOf(death.victim.executable);
    return death.replacement > 0 && death.replacement != death.killed &&
           watcher.WaitUntilReady(death.victim.name, death.replacement, 1);
  });
}

/// Kills one after the other in a random order, each as soon as a number of frames has passed and the last one is
/// back; every fourth time two at a time.
std::vector<Death> KillAtRandom(const WholeRun& run, const RunWatcher& watcher, const Extent& extent, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Death> deaths;
  std::array<int, kVictims.size()> order{};
  std::iota(order.begin(), order.end(), 0);
  const int stride = extent.frames / (extent.kills + 2);
  int64_t frame = 0;
  for (int done = 0; done < extent.kills;) {
    frame = std::max<int64_t>(frame, watcher.Get().newest_frame) + 1 + static_cast<int>(random() % stride);
    if (!watcher.WaitForFrame(std::min<int64_t>(frame, extent.frames - 20), 120)) {
      ADD_FAILURE() << "no progress behind frame " << watcher.Get().newest_frame << '\n' << run.Logs();
      return deaths;
    }
    // Each kind in turn, in an order that changes.
    if (done % static_cast<int>(order.size()) == 0) std::shuffle(order.begin(), order.end(), random);
    const int at_once = done % 4 == 3 && done + 1 < extent.kills ? 2 : 1;
    const size_t first = deaths.size();
    for (int i = 0; i < at_once; ++i, ++done) {
      const Victim& victim = kVictims[static_cast<size_t>(order[static_cast<size_t>(done) % order.size()])];
      const pid_t pid = run.PidOf(victim.executable);
      if (pid < 0 || kill(pid, SIGKILL) != 0) {
        ADD_FAILURE() << victim.name << " does not run";
        continue;
      }
      deaths.push_back({victim, bus::NowS(), pid});
      std::cout << "frame " << watcher.Get().newest_frame << ": " << victim.name << " killed\n";
    }
    for (size_t i = first; i < deaths.size(); ++i) {
      if (!IsReplaced(run, watcher, deaths[i])) ADD_FAILURE() << deaths[i].victim.name << " is not back";
    }
  }
  return deaths;
}

/// Number of kills by process, and the longest time until its replacement published "ready"; for the mapper, the time
/// from then until its map was rebuilt. By name.
struct Toll {
  std::map<std::string, int> killed;
  std::map<std::string, double> back_s;
  double rebuilt_s = 0.0;
};

Toll CountDeaths(const std::vector<Death>& deaths, const Heard& heard) {
  Toll toll;
  for (const Death& death : deaths) {
    const std::string name = death.victim.name;
    ++toll.killed[name];
    const auto alive = heard.alive_at_s.find({name, death.replacement});
    if (alive == heard.alive_at_s.end()) continue;
    toll.back_s[name] = std::max(toll.back_s[name], alive->second - death.at_s);
    const auto running = heard.running_at_s.find({name, death.replacement});
    if (name == "mapping" && running != heard.running_at_s.end()) {
      toll.rebuilt_s = std::max(toll.rebuilt_s, running->second - alive->second);
    }
  }
  for (const auto& [name, n] : toll.killed) {
    std::cout << name << ": killed " << n << " times, back within " << toll.back_s[name] << " s\n";
  }
  std::cout << "the map rebuilt within " << toll.rebuilt_s << " s more\n";
  return toll;
}

/// Checks that all published keyframes are in the map.
void ExpectAllKeyframes(const Heard& heard) {
  for (const auto& [session, keyframes] : heard.keyframes) {
    const auto mapped = heard.mapped.find(session);
    ASSERT_NE(mapped, heard.mapped.end()) << "nothing of session " << session << " with " << keyframes.size();
    EXPECT_TRUE(std::includes(mapped->second.begin(), mapped->second.end(), keyframes.begin(), keyframes.end()))
        << keyframes.size() << " keyframes heard, " << mapped->second.size() << " in the map";
    EXPECT_EQ(*mapped->second.rbegin() + 1, static_cast<int64_t>(mapped->second.size())) << "gap-free";
  }
}

/// Promised times: until a killed process is ready again, and until the mapper has rebuilt its map.
constexpr double kBack_s = 2.0;
constexpr double kRebuilt_s = 2.0;

/// Files that a run leaves behind.
struct Result {
  std::string trajectory;
  std::string keyframes;
  std::string map;
  double ate_m = -1.0;
};

Result ResultOf(const WholeRun& run) {
  return {run.Read("trajectory.tum"), run.Read("keyframes.tum"), run.Read("map.ply"),
          run.Summary()["accuracy"]["ate_m"]};
}

/// A run that is killed at random, all else checked.
Result PlayWithKills(const Extent& extent, unsigned seed) {
  RunWatcher watcher;
  WholeRun run;
  run.Start(Arguments(watcher.url(), extent.frames));
  const std::vector<Death> deaths = KillAtRandom(run, watcher, extent, seed);
  const int code = run.Wait(600);
  EXPECT_EQ(code, 0) << run.Logs();
  if (code != 0) return {};

  const nlohmann::json summary = run.Summary();
  const Heard heard = watcher.Get();
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["frames"], extent.frames);
  EXPECT_EQ(heard.frames.size(), static_cast<size_t>(extent.frames));
  const Toll toll = CountDeaths(deaths, heard);
  for (const auto& [name, n] : toll.killed) {
    EXPECT_EQ(summary["processes"][name]["restarts"], n) << name;
    EXPECT_LT(toll.back_s.at(name), kBack_s) << name;
  }
  EXPECT_LT(toll.rebuilt_s, kRebuilt_s);
  EXPECT_EQ(heard.poses.size(), 1U) << "trackers go on with the session";
  EXPECT_EQ(heard.poses_said_otherwise, 0) << "of " << heard.poses_said_again << " that were said again";
  ExpectAllKeyframes(heard);
  std::cout << "seed " << seed << ": " << heard.poses_said_again << " poses said again, "
            << summary["map"]["keyframes"] << " keyframes\n";
  return ResultOf(run);
}

Result PlayUndisturbed(const Extent& extent) {
  const RunWatcher watcher;
  WholeRun run;
  EXPECT_EQ(run.Run(Arguments(watcher.url(), extent.frames)), 0) << run.Logs();
  EXPECT_EQ(watcher.Get().poses_said_again, 0) << "no process was killed";
  return ResultOf(run);
}

/// By seed.
class Kills : public testing::TestWithParam<unsigned> {};

TEST_P(Kills, ChangeNoBitOfTheResult) {
  if (GetParam() != kFirstSeed && !test::LongTests()) GTEST_SKIP() << "one seed is enough: PLSLAM_LONG_TESTS";
  const Extent extent = ExtentOfTheRun();
  const Result undisturbed = PlayUndisturbed(extent);
  const Result killed = PlayWithKills(extent, GetParam());
  std::cout << "ATE " << killed.ate_m << " m with " << extent.kills << " kills, " << undisturbed.ate_m
            << " m undisturbed\n";
  EXPECT_TRUE(killed.trajectory == undisturbed.trajectory);
  EXPECT_TRUE(killed.keyframes == undisturbed.keyframes);
  EXPECT_TRUE(killed.map == undisturbed.map);
}

INSTANTIATE_TEST_SUITE_P(Random, Kills, testing::Range(kFirstSeed, kFirstSeed + 5),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace plslam
