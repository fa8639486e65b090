// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>

#include "core/datasets/open_dataset.h"
#include "core/io/maps/map_file.h"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/recorded_run.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tools/launch/run_bus.h"

namespace plslam::launcher {
namespace {

using test::RunWatcher;
using test::WholeRun;
using testing::HasSubstr;

/// The run has progressed: its log has a dozen frames or more.
bool HasFrames(const WholeRun& run) {
  return std::filesystem::exists(run.log()) && std::filesystem::file_size(run.log()) > 3'000'000;
}

/// Long enough to be interrupted, in lockstep also on a fast machine.
std::vector<std::string> LongRun(const WholeRun& run, int n_frames = 400) {
  return {"run", fmt::format("synthetic:room?frames={}&size=376x240", n_frames), "--record", run.log()};
}

/// The same, with its map saved as `map`.
std::vector<std::string> LongRunSaving(const WholeRun& run, const std::string& map) {
  std::vector<std::string> arguments = LongRun(run);
  arguments.insert(arguments.end(), {"--save-map", map});
  return arguments;
}

TEST(RunFailure, InterruptLeavesAllFiles) {
  WholeRun run;
  run.Start(LongRun(run));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["completed"], false);
  EXPECT_EQ(summary["reason"], "interrupted");
  EXPECT_GT(summary["frames"], 0);
  for (const auto& [name, process] : summary["processes"].items()) EXPECT_EQ(process["exit_code"], 0) << name;
  EXPECT_FALSE(run.Read("trajectory.tum").empty());
}

TEST(RunFailure, InterruptWithUnwritableOutputsExitsWithOne) {
  WholeRun run;
  run.Start(LongRun(run));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  // No file can be renamed over a folder, not even by root.
  std::filesystem::create_directories(run.out() / "trajectory.tum" / "in the way");
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 1) << run.Logs();
  EXPECT_THAT(run.Logs(), HasSubstr("plslam: error: interrupted; viewer: "));
  const std::string reason = run.Summary()["reason"];
  EXPECT_THAT(reason, HasSubstr("trajectory.tum"));
}

TEST(RunFailure, InterruptSavesTheMapIfRequested) {
  WholeRun run;
  const std::string map = (run.folder() / "room.plmap").string();
  run.Start(LongRunSaving(run, map));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 0) << run.Logs();
  EXPECT_EQ(run.Summary()["reason"], "interrupted");
  EXPECT_GE(ReadMapFile(map).map.keyframes().size(), 1U);
  EXPECT_FALSE(run.Read("trajectory.tum").empty());
}

void SignalAll(const WholeRun& run, int signal) {
  for (const pid_t pid : run.Pids()) kill(pid, signal);
}

bool HasLine(const WholeRun& run, const std::string& text) { return run.Logs().find(text) != std::string::npos; }

// `systemctl stop`, a closing session, `scancel`: all processes get the signal, and the launcher's order besides.
TEST(RunFailure, SignalToAllProcessesAtOnce) {
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    WholeRun run;
    const std::string map = (run.folder() / "room.plmap").string();
    run.Start(signal != SIGINT ? LongRunSaving(run, map) : LongRun(run));
    ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
    SignalAll(run, signal);
    EXPECT_EQ(run.Wait(60), 0) << run.Logs();
    const nlohmann::json summary = run.Summary();
    EXPECT_EQ(summary["reason"], "interrupted");
    for (const auto& [name, process] : summary["processes"].items()) EXPECT_EQ(process["exit_code"], 0) << name;
    EXPECT_FALSE(run.Read("trajectory.tum").empty());
    EXPECT_FALSE(run.Read("report.html").empty());
    if (signal != SIGINT) {
      EXPECT_GE(ReadMapFile(map).map.keyframes().size(), 1U);
    }
    EXPECT_THAT(run.Logs(), HasSubstr("plslam: stopping"));
    EXPECT_FALSE(std::filesystem::exists(run.out() / ".vo_state"));
  }
}

TEST(RunFailure, ClosedTerminalEndsTheRunAsAnInterruptDoes) {
  WholeRun run;
  const std::string map = (run.folder() / "room.plmap").string();
  // The other end of the terminal is closed during the run, and the session gets SIGHUP.
  std::vector<std::string> arguments = {"-qefc", test::BinaryFolder() / "plslam"};
  for (const std::string& word : LongRun(run)) arguments[1] += " '" + word + "'";
  arguments[1] += " --save-map '" + map + "' --out '" + run.out().string() + "'";
  arguments.push_back("/dev/null");
  ChildProcess terminal("/usr/bin/script", arguments, run.folder() / "terminal.log");
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  terminal.Signal(SIGKILL);
  EXPECT_TRUE(WholeRun::WaitFor([&] { return std::filesystem::exists(run.out() / "summary.json"); })) << run.Logs();
  EXPECT_EQ(run.Summary()["reason"], "interrupted") << run.Logs();
  EXPECT_GE(ReadMapFile(map).map.keyframes().size(), 1U);
  EXPECT_FALSE(std::filesystem::exists(run.out() / ".vo_state"));
}

TEST(RunFailure, SecondInterruptLeavesNoProcess) {
  WholeRun run;
  run.Start(LongRun(run));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  const pid_t viewer = run.PidOf("viewer_headless");
  kill(viewer, SIGSTOP);  // would be waited for, for a minute
  const std::vector<pid_t> pids = run.Pids();
  EXPECT_EQ(pids.size(), 7U);
  run.process().Signal(SIGINT);
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasLine(run, "plslam: stopping (Ctrl-C again ends it at once)"); }));
  // Not in the moment of the first, which would count as the same order.
  EXPECT_TRUE(WholeRun::WaitFor([&] {
    run.process().Signal(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return run.ended();
  }));
  EXPECT_EQ(run.Wait(5), 128 + SIGINT) << run.Logs();
  EXPECT_TRUE(WholeRun::WaitFor([&] { return WholeRun::Ended(pids); }));
}

TEST(RunFailure, InterruptDuringMapperRestartSavesTheMap) {
  WholeRun run;
  const std::string map = (run.folder() / "room.plmap").string();
  run.Start(LongRunSaving(run, map));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  ASSERT_TRUE(run.Signal("mapping_process", SIGKILL));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasLine(run, "mapping_process was ended by SIGKILL"); })) << run.Logs();
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 0) << run.Logs();
  EXPECT_GE(ReadMapFile(map).map.keyframes().size(), 1U);
}

TEST(RunFailure, InterruptDuringViewerRestartWritesTrajectory) {
  WholeRun run;
  run.Start(LongRun(run));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  ASSERT_TRUE(run.Signal("viewer_headless", SIGKILL));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasLine(run, "viewer_headless was ended by SIGKILL"); })) << run.Logs();
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 0) << run.Logs();
  const std::string path = run.Read("trajectory.tum");
  EXPECT_GE(std::count(path.begin(), path.end(), '\n'), 10);
  EXPECT_GE(std::count(path.begin(), path.end(), '\n'), run.Summary()["frames"].get<int>());
}

TEST(RunFailure, ProcessKilledBeforeReadyIsRestarted) {
  for (const char* executable : {"player", "mapping_process", "loop_process", "viewer_headless"}) {
    WholeRun run;
    run.Start({"run", "synthetic:room?frames=20&size=160x120"});
    pid_t pid = -1;
    ASSERT_TRUE(WholeRun::WaitFor([&] { return (pid = run.PidOf(executable)) > 0; })) << run.Logs();
    ASSERT_EQ(kill(pid, SIGKILL), 0);
    EXPECT_EQ(run.Wait(), 0) << run.Logs();
    EXPECT_EQ(run.Summary()["tracked_frames"], 20) << run.Logs();
    EXPECT_THAT(run.Logs(), HasSubstr(std::string("plslam: warning: ") + executable +
                                      " was ended by SIGKILL and is started again (1 of 5)\n"));
  }
}

TEST(RunFailure, SharedMapWithoutMapperIsAnError) {
  const PrivatePort port;
  WholeRun run;
  EXPECT_EQ(run.Run({"run", "synthetic:room?frames=20&size=160x120", "--url", port.Url(), "--prefix", "ann/",
                     "--map-prefix", "team/"}),
            1);
  EXPECT_THAT(run.Logs(), HasSubstr("plslam: error: no mapping_process with the prefix team/ was found on "));
  EXPECT_THAT(run.Logs(), HasSubstr("`mapping_process --prefix team/ --url " + port.Url() + "`"));
}

TEST(RunFailure, InterruptBeforeThereIsAMapIsAnError) {
  WholeRun run;
  run.Start({"run", "synthetic:room", "--save-map", (run.folder() / "room.plmap").string()});
  ASSERT_TRUE(WholeRun::WaitFor([&] { return run.PidOf("mapping_process") > 0; })) << run.Logs();
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 1) << run.Logs();
  EXPECT_THAT(run.Logs(), HasSubstr("plslam: error: interrupted before there was a map to save as "));
}

TEST(RunFailure, MapWithoutKeyframesDoesNotReplaceOldMap) {
  WholeRun first, run;
  const std::string map = (first.folder() / "room.plmap").string();
  const std::string world = "synthetic:room?size=160x120&frames=10";
  ASSERT_EQ(first.Run({"run", world, "--save-map", map}), 0) << first.Logs();
  const std::string before = ReadText(map);
  const std::filesystem::path images = run.folder() / "covered";
  WriteImageFolder(*OpenDataset(world, ""), std::vector<test::ChosenFrame>(10, {0, true}), images);
  EXPECT_EQ(run.Run({"run", images.string(), "--save-map", map, "--force"}), 1) << run.Logs();
  EXPECT_THAT(run.Logs(), HasSubstr("plslam: error: the map could not be saved: " + map + ": is not written: "));
  EXPECT_THAT(run.Logs(), testing::Not(HasSubstr("saved map"))) << "it is not of this run";
  EXPECT_TRUE(ReadText(map) == before);
  EXPECT_EQ(run.Summary()["frames"], 10) << "the rest is there";
}

TEST(RunFailure, UnreadableImageEndsTheRunAndTheMapIsSaved) {
  WholeRun whole, run;
  const auto room = OpenDataset("synthetic:room?size=376x240&frames=60", "");
  std::vector<test::ChosenFrame> frames;
  for (int i = 0; i < 60; ++i) frames.push_back({i, false});
  const std::filesystem::path images = run.folder() / "images";
  WriteImageFolder(*room, frames, images);
  const std::string expected = (whole.folder() / "a.plmap").string(), map = (run.folder() / "a.plmap").string();
  ASSERT_EQ(whole.Run({"run", images.string(), "--stop", "40", "--save-map", expected}), 0) << whole.Logs();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(images)) {
    if (entry.path().filename() == "000040.png") std::filesystem::resize_file(entry.path(), 100);
  }
  EXPECT_EQ(run.Run({"run", images.string(), "--save-map", map}), 1) << run.Logs();
  const std::string reason = run.Summary()["reason"];
  EXPECT_THAT(reason, HasSubstr("000040.png"));
  EXPECT_THAT(reason, HasSubstr("--skip-bad"));
  EXPECT_THAT(reason, HasSubstr("the map made so far is saved as " + map));
  EXPECT_EQ(run.Summary()["frames"], 40);
  EXPECT_EQ(run.Summary()["completed"], false);
  EXPECT_EQ(ReadMapFile(map).map.Totals(), ReadMapFile(expected).map.Totals()) << "that of the frames before";
  EXPECT_TRUE(run.Read("map.ply") == whole.Read("map.ply"));
  EXPECT_EQ(run.Read("trajectory.tum"), whole.Read("trajectory.tum"));
}

TEST(RunFailure, SecondRunIntoTheSameFolderIsRefused) {
  WholeRun run;
  run.Start(LongRun(run));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  const std::string log = (run.folder() / "second.log").string();
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"plslam", "run", "synthetic:room", "--out", run.out().string()},
        std::vector<std::string>{"viewer_headless", "--out", run.out().string()}}) {
    ChildProcess second(test::BinaryFolder() / command[0], {command.begin() + 1, command.end()}, log);
    std::optional<ChildExit> end;
    ASSERT_TRUE(WholeRun::WaitFor([&] { return (end = second.Poll()).has_value(); }));
    EXPECT_EQ(end->code, 1) << command[0];
  }
  const std::string named = "process " + std::to_string(run.process().pid()) + " (";
  EXPECT_THAT(ReadText(log), HasSubstr("plslam: error: " + run.out().string() + ": " + named));
  EXPECT_THAT(ReadText(log), HasSubstr("viewer: error: " + run.out().string() + ": " + named));
  EXPECT_THAT(ReadText(log), HasSubstr("synthetic:room?frames=400&size=376x240 --record")) << "its command line";
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 0) << run.Logs();
}

TEST(RunFailure, KilledRecorderContinuesInAnotherFile) {
  WholeRun run;
  run.Start(LongRun(run, 200));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  const auto recorded = std::filesystem::file_size(run.log());
  const pid_t recorder = run.PidOf("plslam");
  ASSERT_GT(recorder, 0);
  ASSERT_EQ(kill(recorder, SIGKILL), 0);
  ASSERT_EQ(run.Wait(), 0) << run.Logs();
  EXPECT_GE(std::filesystem::file_size(run.log()), recorded);
  EXPECT_GT(test::ReadRecordedRun(run.log() + ".2").Count("POSE"), 0);
  EXPECT_EQ(run.Summary()["recordings"], (nlohmann::json{run.log(), run.log() + ".2"}));
  EXPECT_THAT(run.Logs(), HasSubstr("plslam: warning: the recorder was restarted"));
}

TEST(RunFailure, ResultsStayUntilTheNextRunIsAccepted) {
  WholeRun run;
  const std::string world = "synthetic:room?frames=5&size=376x240";
  ASSERT_EQ(run.Run({"run", world, "--overlay-every", "1"}), 0) << run.Logs();
  const std::string summary = run.Read("summary.json"), path = run.Read("trajectory.kitti");
  for (const std::string wrong : {"/nonexistent/sequence", "synthetic:rom"}) {
    EXPECT_EQ(run.Run({"run", wrong}), 1);
    EXPECT_EQ(run.Read("summary.json"), summary);
    EXPECT_EQ(run.Read("trajectory.kitti"), path);
    EXPECT_TRUE(std::filesystem::exists(run.out() / "overlays/000000.png"));
    EXPECT_THAT(run.Logs(), HasSubstr("is still that of the previous run"));
  }
  const std::string text = (run.folder() / "text.plmap").string();
  std::ofstream(text) << "hello";
  EXPECT_EQ(run.Run({"run", world, "--map", text}), 1);
  EXPECT_THAT(run.Logs(), HasSubstr("plslam: error: " + text + ": is not a map file"));
  EXPECT_EQ(run.Read("summary.json"), summary);
  ASSERT_EQ(run.Run({"run", world}), 0) << run.Logs();
  EXPECT_FALSE(std::filesystem::exists(run.out() / "overlays/000000.png"));
  EXPECT_EQ(run.Read("trajectory.kitti"), path) << "written again";
}

TEST(RunFailure, KilledTrackerIsStartedAgain) {
  WholeRun run;
  run.Start(LongRun(run, 120));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  const pid_t tracker = run.PidOf("vo_process");
  ASSERT_GT(tracker, 0);
  ASSERT_EQ(kill(tracker, SIGKILL), 0);
  ASSERT_EQ(run.Wait(), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["processes"]["vo"]["restarts"], 1);
  EXPECT_EQ(summary["frames"], 120) << summary.dump(1);
}

TEST(RunFailure, TrackerWhoseStateIsDamagedBeginsANewSession) {
  RunWatcher watcher;
  WholeRun run;
  run.Start({"run", "synthetic:room?frames=60&size=376x240", "--url", watcher.url()});
  ASSERT_TRUE(watcher.WaitForFrame(20)) << run.Logs();
  const std::filesystem::path state = run.out() / ".vo_state";
  ASSERT_TRUE(run.Signal("vo_process", SIGKILL));
  std::filesystem::resize_file(state, std::filesystem::file_size(state) / 2);
  ASSERT_EQ(run.Wait(), 0) << run.Logs();
  EXPECT_THAT(run.Logs(), HasSubstr("starting a new session: "));
  EXPECT_THAT(run.Logs(), HasSubstr("it was truncated or damaged"));
  EXPECT_EQ(watcher.Get().poses.size(), 2U);
  EXPECT_EQ(run.Summary()["completed"], true);
  EXPECT_FALSE(std::filesystem::exists(state)) << "an orderly exit leaves none";
}

TEST(RunFailure, KilledViewerIsRestartedWithWholeTrajectory) {
  WholeRun run;
  run.Start(LongRun(run, 120));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  const pid_t viewer = run.PidOf("viewer_headless");
  ASSERT_GT(viewer, 0);
  ASSERT_EQ(kill(viewer, SIGKILL), 0);
  ASSERT_EQ(run.Wait(), 0) << run.Logs();
  const std::string path = run.Read("trajectory.tum");
  EXPECT_EQ(std::count(path.begin(), path.end(), '\n'), 120);
}

TEST(RunFailure, ViewerKilledAtTheEndReportsLostPictures) {
  // A camera that is distorted and turned, which the rectified one is not.
  const std::string world = "synthetic:room?frames=40&size=376x240&distorted=1";
  WholeRun undisturbed, run;
  const RunWatcher watcher;
  ASSERT_EQ(undisturbed.Run({"run", world, "--overlay-every", "10"}), 0) << undisturbed.Logs();
  run.Start({"run", world, "--overlay-every", "10", "--url", watcher.url(), "--set", "player.exit=true", "--set",
             "bus.give_up_s=2"});
  ASSERT_TRUE(watcher.WaitForFrame(5)) << run.Logs();
  // While stopped, it neither receives the rest nor ends the run before the player has exited.
  const pid_t viewer = run.PidOf("viewer_headless");
  ASSERT_GT(viewer, 0);
  ASSERT_EQ(kill(viewer, SIGSTOP), 0);
  ASSERT_TRUE(watcher.WaitForFrame(39)) << run.Logs();
  ASSERT_TRUE(WholeRun::WaitFor([&] { return run.PidOf("player") < 0; })) << run.Logs();
  ASSERT_EQ(kill(viewer, SIGKILL), 0);
  EXPECT_EQ(run.Wait(120), 1) << run.Logs();
  for (const char* file :
       {"trajectory.tum", "trajectory_live.tum", "keyframes.tum", "covariance.txt", "groundtruth.tum"}) {
    EXPECT_TRUE(run.Read(file) == undisturbed.Read(file)) << file;
  }
  EXPECT_THAT(run.Logs(),
              testing::ContainsRegex("plslam: error: viewer: .* of 4 pictures are missing in .*/overlays: "));
  EXPECT_THAT(run.Logs(), testing::ContainsRegex("plslam: warning: [0-9]+ of [0-9]+ frames have no picture"));
  EXPECT_GT(run.Summary()["missing_pictures"], 20);
  EXPECT_THAT(run.Read("report.html"), HasSubstr("pictures of frames are missing"));
}

TEST(RunFailure, MissingDatasetIsOneSentence) {
  WholeRun run;
  EXPECT_EQ(run.Run({"run", "/nonexistent/sequence"}), 1);
  EXPECT_THAT(run.Logs(), HasSubstr("plslam: error: player: "));
  EXPECT_THAT(run.Logs(), HasSubstr("/nonexistent/sequence"));
}

TEST(RunFailure, UnknownOptionStopsBeforeTheFirstFrame) {
  WholeRun run;
  EXPECT_EQ(run.Run({"run", "synthetic:room", "--set", "vo.features.orb.max_point=800"}), 1);
  EXPECT_THAT(run.Logs(), HasSubstr("unknown key 'vo.features.orb.max_point'; the nearest known one is "
                                    "'vo.features.orb.max_points'"));
  EXPECT_FALSE(std::filesystem::exists(run.out())) << "it came to nothing";
  EXPECT_EQ(run.Run({"run", "/nonexistent/sequence"}), 1);
  EXPECT_EQ(run.Logs().find("is still that of the previous run"), std::string::npos) << run.Logs();
  EXPECT_FALSE(std::filesystem::exists(run.out()));
}

TEST(RunFailure, BusOfTheConfigurationFileIsUsed) {
  WholeRun run;
  const RunWatcher watcher;
  const std::string file = (run.folder() / "bus.yaml").string();
  std::ofstream(file) << "bus:\n  url: " << watcher.url() << "\nplayer:\n  stop: 5\n";
  EXPECT_EQ(run.Run({"run", "synthetic:room?size=160x120", "--config", file}), 0) << run.Logs();
  EXPECT_EQ(watcher.Get().newest_frame, 4);
  std::ofstream(file) << "bus:\n  url: nonsense\n";
  WholeRun wrong;
  EXPECT_EQ(wrong.Run({"run", "synthetic:room?size=160x120", "--config", file}), 1);
  EXPECT_THAT(wrong.Logs(), HasSubstr("nonsense"));
  EXPECT_FALSE(std::filesystem::exists(wrong.out()));
}

TEST(RunFailure, LauncherThatIsKilledEndsItsProcesses) {
  WholeRun run;
  run.Start(LongRun(run));
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasFrames(run); })) << run.Logs();
  const std::vector<pid_t> pids = run.Pids();
  ASSERT_GT(pids.size(), 4U);
  run.process().Signal(SIGKILL);
  run.Wait();
  // They write their files before they exit, into the folder that the test removes.
  EXPECT_TRUE(WholeRun::WaitFor([&] { return WholeRun::Ended(pids); }));
}

}  // namespace
}  // namespace plslam::launcher
