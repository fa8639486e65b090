// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/integration/run_watcher.h"
#include "tests/integration/stored_map_bytes.h"
#include "tests/integration/whole_run.h"

namespace plslam {
namespace {

using test::RunWatcher;
using test::WholeRun;

/// One that is killed when this frame has been seen.
struct Kill {
  int64_t frame = 0;
  std::string name;
  std::string executable;
};

Kill MapperAt(int64_t frame) { return {frame, "mapping", "mapping_process"}; }
Kill LoopAt(int64_t frame) { return {frame, "loop", "loop_process"}; }

struct MappedRun {
  std::string trajectory;
  std::string keyframes;
  std::string points;  ///< map.ply
  std::vector<uint8_t> map;
};

/// Two laps of a small room with a loop, keyframes culled; each is killed when the one before is back.
MappedRun Play(const std::string& state_every, const std::vector<Kill>& kills) {
  const RunWatcher watcher;
  WholeRun run;
  const std::filesystem::path map = run.folder() / "end.plmap";
  run.Start({"run", "synthetic:room?size=376x240&frames=300&loops=2", "--url", watcher.url(), "--max-restarts", "100",
             "--save-map", map.string(), "--set", "mapping.state_every=" + state_every});
  for (const Kill& death : kills) {
    EXPECT_TRUE(watcher.WaitForFrame(death.frame, 120)) << run.Logs();
    const pid_t pid = run.PidOf(death.executable);
    EXPECT_TRUE(pid > 0 && kill(pid, SIGKILL) == 0) << death.name << " at " << death.frame;
    EXPECT_TRUE(WholeRun::WaitFor([&] {
      const pid_t next = run.PidOf(death.executable);
      return next > 0 && next != pid && watcher.WaitUntilReady(death.name, next, 1);
    })) << run.Logs();
  }
  EXPECT_EQ(run.Wait(), 0) << run.Logs();
  EXPECT_EQ(run.Summary()["completed"], true);
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["tracked_frames"], 300);
  EXPECT_GE(summary["loops"], 1);
  for (const char* process : {"vo", "mapping", "loop"}) {
    EXPECT_EQ(summary["processes"][process]["restarts"], std::ranges::count(kills, process, &Kill::name)) << process;
  }
  return {run.Read("trajectory.tum"), run.Read("keyframes.tum"), run.Read("map.ply"), test::BytesWithoutName(map)};
}

void ExpectSame(const MappedRun& a, const MappedRun& b) {
  EXPECT_TRUE(a.trajectory == b.trajectory);
  EXPECT_TRUE(a.keyframes == b.keyframes);
  EXPECT_TRUE(a.points == b.points);
  EXPECT_EQ(test::DifferenceOf(a.map, b.map), "");
}

TEST(KilledMapper, RestartGivesTheSameBits) {
  const MappedRun undisturbed = Play("10", {});
  // The loop is closed at about frame 270.
  ExpectSame(Play("10", {MapperAt(30), MapperAt(150), LoopAt(180), MapperAt(240), MapperAt(270), MapperAt(285)}),
             undisturbed);
  // Without a state file, from the histories of running and exited processes.
  ExpectSame(Play("1000", {LoopAt(120), MapperAt(180), MapperAt(275)}), undisturbed);
}

}  // namespace
}  // namespace plslam
