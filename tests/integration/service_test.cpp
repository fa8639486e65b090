// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/io/maps/map_file.h"
#include "core/io/trajectories/trajectory.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"

namespace plslam {
namespace {

using test::Heard;
using test::RunWatcher;
using test::WholeRun;
using testing::HasSubstr;

constexpr const char* kRoom = "synthetic:room?size=376x240&frames=80";

bool HasNewestKeyframes(const Heard& heard) {
  return std::ranges::all_of(heard.keyframes, [&](const auto& session) {
    const auto mapped = heard.mapped.find(session.first);
    return mapped != heard.mapped.end() && mapped->second.contains(*session.second.rbegin());
  });
}

/// Processes started one by one on a private bus, with state files that stay, as services have them.
class Service : public testing::Test {
 protected:
  using Child = std::unique_ptr<launcher::ChildProcess>;

  Child Spawn(const std::string& program, std::vector<std::string> arguments, const std::string& log) const {
    arguments.insert(arguments.end(), {"--url", watcher_.url()});
    return std::make_unique<launcher::ChildProcess>(test::BinaryFolder() / program, arguments, run_.folder() / log);
  }
  std::string File(const std::string& name) const { return (run_.folder() / name).string(); }
  std::string Log(const std::string& name) const { return ReadText(run_.folder() / name); }

  /// Starts vo, mapping or loop, and waits until it is ready.
  void Start(const std::string& name) {
    std::vector<std::string> arguments;
    if (name != "loop") arguments = {"--set", name + ".state_file=" + File(name + ".state")};
    children_[name] = Spawn(name + "_process", arguments, name + ".log");
    ASSERT_TRUE(watcher_.WaitUntilReady(name, children_[name]->pid())) << Log(name + ".log");
  }
  /// Ends a process as systemd does; returns its exit code.
  int Stop(const std::string& name) {
    children_[name]->Signal(SIGTERM);
    return CodeOf(*children_[name]);
  }
  int CodeOf(launcher::ChildProcess& child) const {
    EXPECT_TRUE(WholeRun::WaitFor([&] { return child.Poll().has_value(); }));
    return child.Poll().value_or(launcher::ChildExit{-1}).code;
  }
  void Play(const std::string& dataset) {
    Child player = Spawn("player", {dataset, "--exit"}, "player.log");
    ASSERT_EQ(CodeOf(*player), 0) << Log("player.log");
    // The player ends with the pose of the last frame; its keyframe may still be on its way to the map.
    ASSERT_TRUE(watcher_.WaitFor([](const Heard& heard) {
      const auto vo = heard.status.find("vo");
      return vo != heard.status.end() && vo->second.state == "finished" && HasNewestKeyframes(heard);
    })) << Log("vo.log")
        << Log("mapping.log");
  }
  /// Returns the exit code of `plslam ARGUMENTS...`; its output is in `order.log`.
  int Order(const std::vector<std::string>& arguments) {
    std::filesystem::remove(File("order.log"));
    Child order = Spawn("plslam", arguments, "order.log");
    return CodeOf(*order);
  }

  const WholeRun run_;
  RunWatcher watcher_;
  std::map<std::string, Child> children_;
};

TEST_F(Service, OrderlyStopKeepsTheMap) {
  for (const char* name : {"mapping", "loop", "vo"}) ASSERT_NO_FATAL_FAILURE(Start(name));
  EXPECT_THAT(Log("mapping.log"), HasSubstr("waiting for keyframes"));
  ASSERT_NO_FATAL_FAILURE(Play(kRoom));
  ASSERT_EQ(Order({"save", File("before.plmap")}), 0) << Log("order.log");
  const size_t n = ReadMapFile(File("before.plmap")).map.keyframes().size();
  ASSERT_GT(n, 3U);
  for (const char* name : {"vo", "mapping", "loop"}) EXPECT_EQ(Stop(name), 0) << Log(std::string(name) + ".log");
  EXPECT_TRUE(std::filesystem::exists(File("mapping.state")));

  for (const char* name : {"loop", "vo", "mapping"}) ASSERT_NO_FATAL_FAILURE(Start(name));
  ASSERT_EQ(Order({"save", File("after.plmap")}), 0) << Log("order.log") << Log("mapping.log");
  EXPECT_EQ(ReadMapFile(File("after.plmap")).map.keyframes().size(), n);
  EXPECT_THAT(Log("mapping.log"), HasSubstr("continuing the map in " + File("mapping.state")));

  // The map grows from there.
  ASSERT_NO_FATAL_FAILURE(Play(kRoom));
  ASSERT_EQ(Order({"save", File("after.plmap")}), 0)
      << "an older state of this map is replaced: " << Log("order.log");
  EXPECT_GT(ReadMapFile(File("after.plmap")).map.keyframes().size(), n);

  // "reset" begins a new map, and so does a missing file.
  ASSERT_EQ(Order({"reset"}), 0);
  EXPECT_EQ(Stop("mapping"), 0);
  ASSERT_NO_FATAL_FAILURE(Start("mapping"));
  const std::string begins = "beginning a new map: that in " + File("mapping.state") + " is empty";
  EXPECT_TRUE(WholeRun::WaitFor([&] { return Log("mapping.log").find(begins) != std::string::npos; }))
      << Log("mapping.log");
  EXPECT_EQ(Stop("mapping"), 0);
  std::filesystem::remove(File("mapping.state"));
  for (const char* name : {"vo", "loop"}) EXPECT_EQ(Stop(name), 0);
}

TEST_F(Service, SecondProcessOfANameRefusesToStart) {
  ASSERT_NO_FATAL_FAILURE(Start("vo"));
  Child second = Spawn("vo_process", {}, "second.log");
  EXPECT_EQ(CodeOf(*second), 1);
  EXPECT_THAT(Log("second.log"),
              HasSubstr("another vo is running on this bus: process " + std::to_string(children_["vo"]->pid())));
  EXPECT_THAT(Log("second.log"), HasSubstr("--prefix"));
  EXPECT_FALSE(children_["vo"]->Poll()) << "the first one continues";
  Child other = Spawn("vo_process", {"--prefix", "two/"}, "other.log");
  EXPECT_TRUE(WholeRun::WaitFor([&] { return Log("other.log").find("ready on") != std::string::npos; }));
  EXPECT_FALSE(other->Poll()) << "another prefix is another robot";

  // A run beside it fails at its start, and names the process.
  EXPECT_EQ(Order({"run", kRoom, "--out", File("out2"), "--quiet"}), 1);
  EXPECT_THAT(Log("order.log"), HasSubstr("another vo is running on this bus"));
}

TEST_F(Service, ExistingFilesAreNotReplaced) {
  ASSERT_NO_FATAL_FAILURE(Start("mapping"));
  ASSERT_NO_FATAL_FAILURE(Start("vo"));
  ASSERT_NO_FATAL_FAILURE(Play(kRoom));
  const std::string text = File("rig.yaml");
  std::ofstream(text) << "kind: stereo\n";
  EXPECT_EQ(Order({"save", text}), 1);
  EXPECT_THAT(Log("order.log"), HasSubstr("is not a map; give another name, or --force"));
  EXPECT_EQ(ReadText(text), "kind: stereo\n");
  EXPECT_EQ(Order({"record", text}), 1);
  EXPECT_EQ(ReadText(text), "kind: stereo\n");
  EXPECT_EQ(Order({"save", text, "--force"}), 0) << Log("order.log");
  EXPECT_FALSE(ReadMapFile(text).map.keyframes().empty());
  EXPECT_EQ(Order({"run", kRoom, "--save-map", text, "--out", File("out3")}), 1);
  EXPECT_THAT(Log("order.log"), HasSubstr("exists already"));
}

TEST(MapOfAnotherPlace, IsReportedAndKeptApart) {
  WholeRun run;
  const std::string map = (run.folder() / "room.plmap").string();
  ASSERT_EQ(run.Run({"run", "synthetic:room?size=376x240&frames=60", "--save-map", map}), 0) << run.Logs();
  const std::string other = "synthetic:street?size=376x240&rate=10&frames=40";
  EXPECT_EQ(run.Run({"run", other, "--map", map, "--strict"}), 2) << run.Logs();
  EXPECT_THAT(run.Summary()["warnings"].dump(), HasSubstr("not_in_map"));
  EXPECT_EQ(ReadTrajectory((run.out() / "trajectory.tum").string()).size(),
            run.Summary()["tracked_frames"].get<size_t>());
  EXPECT_FALSE(run.Read("part2/map.ply").empty()) << "the room";
  EXPECT_FALSE(std::filesystem::exists(run.out() / "part2/trajectory.tum"));
  EXPECT_EQ(run.Run({"run", other, "--map", map, "--localise-only"}), 1) << "no frame has a place";
  EXPECT_THAT(run.Summary()["reason"].dump(), HasSubstr("was not recognised in"));
}

TEST(MapOfThisPlace, LivePosesAreRightFromTheThirdFrameOn) {
  WholeRun run;
  const std::string map = (run.folder() / "room.plmap").string();
  ASSERT_EQ(run.Run({"run", "synthetic:room?size=376x240&frames=300", "--save-map", map}), 0) << run.Logs();
  ASSERT_EQ(run.Run({"run", "synthetic:room?size=376x240&frames=300", "--start", "120", "--stop", "170", "--map", map,
                     "--strict"}),
            0)
      << run.Logs();
  const auto summary = run.Summary();
  EXPECT_LT(summary["accuracy_live_ate_m"].get<double>(), 0.02) << summary.dump(1);
}

}  // namespace
}  // namespace plslam
