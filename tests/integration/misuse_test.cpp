// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/key_file.h"
#include "tests/support/shell.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"

namespace plslam {
namespace {

using test::KeyFile;
using test::RunWatcher;
using test::WholeRun;
using testing::HasSubstr;

const std::string kShortRoom = "synthetic:room?frames=60&size=376x240";

/// Output and exit code of a program in a test's folder.
struct Outcome {
  int code = -1;
  std::string log;
  double seconds = 0.0;
};

Outcome RunProgram(const WholeRun& run, const std::filesystem::path& program,
                   const std::vector<std::string>& arguments) {
  const std::filesystem::path log = run.folder() / "program.log";
  std::filesystem::remove(log);
  const auto began = std::chrono::steady_clock::now();
  launcher::ChildProcess child(program, arguments, log);
  EXPECT_TRUE(WholeRun::WaitFor([&] { return child.Poll().has_value(); }));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  return {child.Poll().value_or(launcher::ChildExit{-1}).code, ReadText(log), took.count()};
}

Outcome Plslam(const WholeRun& run, const std::vector<std::string>& arguments) {
  return RunProgram(run, test::BinaryFolder() / "plslam", arguments);
}

TEST(Misuse, SecondRunOnABusIsRefused) {
  const RunWatcher watcher;
  WholeRun first, second;
  // In lockstep no frame is skipped, however busy the machine is.
  first.Start({"run", kShortRoom, "--url", watcher.url()});
  ASSERT_TRUE(watcher.WaitForFrame(5)) << first.Logs();
  // It is still under way however long the second one takes.
  ASSERT_TRUE(first.Signal("player", SIGSTOP));
  EXPECT_EQ(second.Run({"run", kShortRoom, "--url", watcher.url()}), 1);
  ASSERT_TRUE(first.Signal("player", SIGCONT));
  EXPECT_THAT(second.Logs(), HasSubstr("is running on this bus: process "));
  EXPECT_THAT(second.Logs(), HasSubstr("--prefix"));
  EXPECT_FALSE(std::filesystem::exists(second.out())) << "frames of the first run are no result of the second";
  EXPECT_EQ(first.Wait(), 0) << first.Logs();
  EXPECT_EQ(first.Summary()["frames"], 60);
  EXPECT_EQ(first.Summary()["sessions"].size(), 1U);
}

TEST(Misuse, LogReplayedBesideARunIsReported) {
  if (!test::HasProgram("lcm-logplayer")) GTEST_SKIP() << "no lcm-logplayer";
  WholeRun recorded, live;
  ASSERT_EQ(recorded.Run(
                {"run", "synthetic:room?frames=160&size=376x240", "--pace", "realtime", "--record", recorded.log()}),
            0)
      << recorded.Logs();
  const RunWatcher watcher;
  live.Start(
      {"run", "synthetic:room?frames=240&size=376x240", "--url", watcher.url(), "--pace", "realtime", "--strict"});
  ASSERT_TRUE(watcher.WaitForFrame(40)) << live.Logs();
  // Without what announces messages that are missing from the mixture: readers would wait for them for a minute.
  const Outcome player =
      RunProgram(live, "/usr/bin/lcm-logplayer",
                 {"-l", watcher.url(), "-e", "^(STATUS|POSE|STEREO_FRAME|KEYFRAME)$", recorded.log()});
  EXPECT_EQ(player.code, 0) << player.log;
  EXPECT_EQ(live.Wait(), 2) << live.Logs();
  EXPECT_THAT(live.Summary()["warnings"].dump(), HasSubstr("another_process"));
  EXPECT_THAT(live.Logs(), HasSubstr("results are a mixture of both"));
}

TEST(Misuse, OrdersWithoutTheKeyFailAtOnce) {
  const RunWatcher watcher;
  const WholeRun run;
  const std::string key = KeyFile(run.folder(), '1'), other = KeyFile(run.folder(), '2');
  launcher::ChildProcess mapping(test::BinaryFolder() / "mapping_process",
                                 {"--url", watcher.url(), "--set", "bus.key_file=" + key},
                                 run.folder() / "mapping.log");
  ASSERT_TRUE(WholeRun::WaitFor(
      [&] { return ReadText(run.folder() / "mapping.log").find("waiting for keyframes") != std::string::npos; }));
  const std::string file = (run.folder() / "a.plmap").string();
  for (const auto& [arguments, sentence] : {std::pair(std::vector<std::string>{}, "this system uses bus.key_file"),
                                            std::pair(std::vector<std::string>{"--set", "bus.key_file=" + other},
                                                      "this system uses another bus.key_file")}) {
    std::vector<std::string> command{"save", file, "--url", watcher.url()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const Outcome order = Plslam(run, command);
    EXPECT_EQ(order.code, 1);
    EXPECT_THAT(order.log, HasSubstr(sentence));
    EXPECT_LT(order.seconds, 6.0) << "two seconds on a machine without other load";
  }
  const Outcome order = Plslam(run, {"save", file, "--url", watcher.url(), "--set", "bus.key_file=" + key});
  EXPECT_EQ(order.code, 1);
  EXPECT_THAT(order.log, HasSubstr("there is no map"));
}

TEST(Misuse, ResultsOfTwoRunsAreNotMixed) {
  WholeRun run;
  const std::string map = (run.out() / "map.plmap").string();
  std::filesystem::create_directories(run.out());
  ASSERT_EQ(run.Run({"run", kShortRoom, "--save-map", map}), 0) << run.Logs();
  ASSERT_TRUE(std::filesystem::exists(map)) << run.Logs();
  ASSERT_EQ(run.Run({"run", "synthetic:corridor?frames=40&size=376x240"}), 0) << run.Logs();
  const Outcome exported = Plslam(run, {"export", run.out().string(), "--out", (run.folder() / "export").string()});
  EXPECT_EQ(exported.code, 1);
  EXPECT_THAT(exported.log, HasSubstr("is of another run than the results in"));
  const Outcome figures = RunProgram(run, test::BinaryFolder() / "evaluate",
                                     {"figures", run.out().string(), "--out", (run.folder() / "figures").string()});
  EXPECT_EQ(figures.code, 1);
  EXPECT_THAT(figures.log, HasSubstr("is of another run than the results in"));
}

TEST(Misuse, MistypedCommandIsNamed) {
  const WholeRun run;
  const Outcome outcome = Plslam(run, {"rum", kShortRoom});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.log, "plslam: error: there is no command 'rum'; the nearest is 'run' (--help lists all)\n");
}

TEST(Misuse, MistypedOptionIsNamed) {
  const WholeRun run;
  const Outcome outcome = Plslam(run, {"run", kShortRoom, "--feature=points"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.log,
            "plslam: error: there is no option '--feature'; the nearest is '--features' (--help lists all)\n");
  EXPECT_THAT(Plslam(run, {"export", "--fromat", "ply"}).log, HasSubstr("the nearest is '--format'"));
}

TEST(Misuse, UnexpectedWordIsNamedBeforeMissingOptions) {
  const WholeRun run;
  EXPECT_EQ(RunProgram(run, test::BinaryFolder() / "evaluate", {"compre", "a"}).log,
            "evaluate: error: 'a' was not expected (--help lists all)\n");
}

TEST(Misuse, RecordingOfAnEmptyBusIsReported) {
  const WholeRun run;
  const std::filesystem::path log = run.folder() / "record.log";
  launcher::ChildProcess record(test::BinaryFolder() / "plslam", {"record", run.log(), "--url", "memq://"}, log);
  // One second of its own statuses.
  ASSERT_TRUE(WholeRun::WaitFor(
      [&] { return std::filesystem::exists(run.log()) && std::filesystem::file_size(run.log()) > 0; }));
  record.Signal(SIGINT);
  ASSERT_TRUE(WholeRun::WaitFor([&] { return record.Poll().has_value(); }));
  EXPECT_THAT(ReadText(log), HasSubstr("warning: there was no frame, pose or map on memq://; give the --url"));
}

TEST(Misuse, HelpIsACommand) {
  const WholeRun run;
  EXPECT_THAT(Plslam(run, {"help"}).log, HasSubstr("plslam replay"));
  EXPECT_THAT(Plslam(run, {"help", "run"}).log, HasSubstr("--features"));
  EXPECT_THAT(Plslam(run, {"help", "export"}).log, HasSubstr("--format"));
}

TEST(Misuse, SettingsWithoutEffectAreRefused) {
  const auto error_of = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"run", "synthetic:room?frames=4&size=160x120"});
    WholeRun run;
    EXPECT_EQ(run.Run(arguments), 1);
    EXPECT_FALSE(std::filesystem::exists(run.out()));
    return run.Logs();
  };
  EXPECT_THAT(error_of({"--no-mapping", "--set", "mapping.state_every=4"}),
              HasSubstr("--set mapping.state_every=4: this run starts no mapping_process"));
  EXPECT_THAT(error_of({"--set", "dense.voxel_m=0.1"}), HasSubstr("starts no dense_process"));
  EXPECT_THAT(error_of({"--set", "adapter.left=/left"}), HasSubstr("starts no adapter"));
  EXPECT_THAT(error_of({"--pace", "fast"}), HasSubstr("pace 'fast' is not one of lockstep, realtime"));
  EXPECT_THAT(error_of({"--video", "film.avi"}), HasSubstr("--video film.avi: films are MP4 files"));
  EXPECT_THAT(error_of({"--stop", "3", "--set", "player.stop=2"}),
              HasSubstr("--set player.stop=2: the arguments of `plslam run` decide, with player.stop=3"));
}

TEST(Misuse, CommandsOnFilesAreListedByBothPrograms) {
  const WholeRun run;
  const std::string listed = Plslam(run, {"--help"}).log;
  std::istringstream help(RunProgram(run, test::BinaryFolder() / "plslam_offline", {"--help"}).log);
  int n = 0;
  for (std::string line; std::getline(help, line);) {
    if (!line.starts_with("  ") || line.starts_with("  -")) continue;
    EXPECT_THAT(listed, HasSubstr(line + "\n"));
    ++n;
  }
  EXPECT_GE(n, 6);
}

TEST(Misuse, HelpHasDefaultsAndNothingForLaunchers) {
  const WholeRun run;
  EXPECT_THAT(RunProgram(run, test::BinaryFolder() / "evaluate", {"--help"}).log, HasSubstr("=0.02"));
  EXPECT_THAT(Plslam(run, {"run", "--help"}).log, HasSubstr("--max-restarts INT"));
  for (const char* command : {"save", "top", "doctor"}) {
    EXPECT_THAT(Plslam(run, {command, "--help"}).log, testing::Not(HasSubstr("--parent"))) << command;
  }
}

}  // namespace
}  // namespace plslam
