// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/io/maps/map_file.h"
#include "tests/integration/recorded_run.h"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"
#include "tests/unit/export/small_map.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::Heard;
using test::OnASmallDisk;
using test::RunWatcher;
using test::WholeRun;
using testing::HasSubstr;

const std::string kWorld = "synthetic:room?size=160x120&frames=40";
const std::string kLongWorld = "synthetic:room?size=376x240&frames=400";

std::vector<std::string> HalfWritten(const fs::path& folder) {
  std::vector<std::string> names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const bool empty = entry.is_regular_file() && entry.path().extension() != ".log" && entry.file_size() == 0;
    if (entry.path().extension() == ".part" || empty) names.push_back(entry.path().string());
  }
  return names;
}

/// Returns the number of lines that report an error.
int Sentences(const std::string& log, const std::string& of) {
  int count = 0;
  for (size_t at = log.find(of); at != std::string::npos; at = log.find(of, at + 1)) ++count;
  return count;
}

std::string Plslam() { return (test::BinaryFolder() / "plslam").string(); }

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Resources, FullDiskUnderTheOutputs) {
  const WholeRun run;
  const fs::path disk = run.folder() / "disk", found = run.folder() / "found";
  // The final content of the disk is copied out of the mount namespace.
  const auto code = OnASmallDisk(
      disk, 96,
      fmt::format(
          "{} run '{}' --out '{}' --overlay-every 1 --max-restarts 1; code=\\$?; cp -r '{}' '{}'; exit \\$code",
          Plslam(), kWorld, disk.string(), disk.string(), found.string()));
  if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
  const std::string log = ReadFile(run.folder() / "disk.sh.log");
  EXPECT_EQ(*code, 1) << log;
  EXPECT_THAT(log, HasSubstr("No space left on device"));
  EXPECT_EQ(Sentences(log, "plslam: error: "), 1) << log;
  EXPECT_THAT(log, testing::Not(HasSubstr("SIGABRT"))) << "the log of the viewer is on the full disk, too";
  EXPECT_THAT(HalfWritten(found), testing::IsEmpty());
}

/// A run that writes only its film to a disk of so many KiB, of which the first `filled_kib` are occupied.
void ExpectNoFilm(int kib, int filled_kib) {
  const WholeRun run;
  const fs::path disk = run.folder() / "disk", found = run.folder() / "found";
  const auto code = OnASmallDisk(
      disk, kib,
      fmt::format("(dd if=/dev/zero of='{0}/full' bs=1k count={1}; {2} run '{3}' --out '{4}' --video '{0}/film.mp4'; "
                  "code=\\$?; cp -r '{0}' '{5}'; exit \\$code)",
                  disk.string(), filled_kib, Plslam(), kWorld, run.out().string(), found.string()));
  if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
  const std::string log = ReadFile(run.folder() / "disk.sh.log") + run.Logs();
  EXPECT_EQ(*code, 1) << log;
  EXPECT_THAT(
      ReadFile(run.folder() / "disk.sh.log"),
      testing::ContainsRegex("plslam: error: viewer: .*film.mp4: cannot be written: No space left on device"));
  for (const auto& entry : fs::directory_iterator(found)) EXPECT_EQ(entry.path().filename(), "full") << log;
  EXPECT_FALSE(run.Read("trajectory.tum").empty()) << "all else is there";
  EXPECT_FALSE(run.Read("map.ply").empty());
}

TEST(Resources, FilmOnAFullDisk) { ExpectNoFilm(64, 64); }

TEST(Resources, FilmThatFillsTheDisk) { ExpectNoFilm(64, 8); }
// The outputs are on another disk: the sentence itself names the file that cannot be written.
TEST(Resources, FullDiskUnderTheMapIsTheReportedReason) {
  const WholeRun run;
  const fs::path disk = run.folder() / "disk", found = run.folder() / "found";
  const auto code = OnASmallDisk(
      disk, 16,
      fmt::format("{} run '{}' --out '{}' --save-map '{}/room.plmap'; code=\\$?; cp -r '{}' '{}'; exit \\$code",
                  Plslam(), kWorld, run.out().string(), disk.string(), disk.string(), found.string()));
  if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
  const std::string log = ReadFile(run.folder() / "disk.sh.log");
  EXPECT_EQ(*code, 1) << log;
  EXPECT_THAT(log,
              testing::ContainsRegex("room.plmap: cannot be written: No space left on device .it has [0-9]+ bytes"));
  EXPECT_TRUE(fs::is_empty(found));
}

TEST(Resources, FullDiskUnderTheRecordingEndsNothing) {
  const WholeRun run;
  const fs::path disk = run.folder() / "disk", found = run.folder() / "found.lcm";
  const std::string map = (run.folder() / "room.plmap").string();
  const auto code = OnASmallDisk(
      disk, 400,
      fmt::format(
          "{0} run '{1}' --out '{2}' --record '{3}/run.lcm' --save-map '{4}'; code=\\$?; cp '{3}/run.lcm' '{5}'; "
          "exit \\$code",
          Plslam(), kWorld, run.out().string(), disk.string(), map, found.string()));
  if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
  const std::string log = ReadFile(run.folder() / "disk.sh.log");
  EXPECT_EQ(*code, 1) << log;
  EXPECT_EQ(Sentences(log, "plslam: warning: "), 1) << log;
  EXPECT_EQ(Sentences(log, "run.lcm: cannot be written: No space left on device: the recording ends here"), 1) << log;
  EXPECT_THAT(log, HasSubstr("plslam: error: recorder ended with exit code 1"));
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["tracked_frames"], 40) << summary.dump(1);
  EXPECT_THAT(summary["warnings"].dump(), HasSubstr("recording_stopped"));
  EXPECT_TRUE(fs::exists(map)) << log;
  EXPECT_GT(test::ReadRecordedRun(found.string()).Count("POSE"), 0) << "the part before";
}

TEST(Resources, FullDiskUnderStandardOutput) {
  const ScratchFolder folder;
  for (const std::string command :
       {"plslam config", "plslam --help", "plslam processes", "plslam export --help", "plslam refine --help",
        "plslam rectify-check --help", "evaluate --help", "pose_graph --help", "train_vocabulary --help",
        "vo_process --help", "dense_process --help", "viewer_headless --version", "plslam_film --help"}) {
    const fs::path program = test::BinaryFolder() / command.substr(0, command.find(' '));
    if (!fs::exists(program)) continue;  // built without OctoMap or GStreamer
    const std::string line = (test::BinaryFolder() / command).string() + " > /dev/full";
    const test::ShellResult result = test::Shell(folder, line);
    EXPECT_EQ(result.exit_code, 1) << command;
    EXPECT_THAT(result.error, HasSubstr("standard output: cannot be written")) << command;
    EXPECT_EQ(test::Shell(folder, line + " 2> /dev/full").exit_code, 1) << command;
  }
}

// Every program that writes a file of its own reports a full disk.
TEST(Resources, FullDiskUnderAFileOfATool) {
  const ScratchFolder folder;
  const std::string poses = folder.Write("a.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 1 1 0 0 0 0 1\n");
  const std::string graph =
      folder.Write("a.g2o",
                   "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n"
                   "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n");
  const std::string map = folder.Path("a.plmap");
  WriteMapFile(map, test::SmallStoredMap());
  const std::string bin = test::BinaryFolder().string() + "/";
  // Outputs that are written beside their place, and then moved there, need a folder on the full disk.
  const fs::path disk = folder.Path("disk");
  const std::string commands[] = {
      fmt::format("evaluate {0} --truth {0} --json DISK/a.json", poses),
      fmt::format("evaluate {0} --truth {0} --plot DISK/a.png", poses),
      fmt::format("pose_graph {} --out DISK/b.g2o", graph),
      "plslam calibrate --board chess:9x6:0.025 --print-board DISK/board.pdf",
      fmt::format("plslam export {} --out DISK/a", map),
      fmt::format("plslam refine {} --out DISK/a", map),
      "plslam rectify-check 'synthetic:room?frames=2&size=160x120' --out DISK/a.png",
      "train_vocabulary --kind points --branching 2 --depth 2 'synthetic:room?frames=2&size=160x120' --out DISK/a",
  };
  for (const std::string& command : commands) {
    std::string line = bin + command;
    line.replace(line.find("DISK"), 4, "'" + disk.string() + "'");
    fs::remove(disk.string() + ".sh.log");
    // One file fills the disk.
    const auto code =
        OnASmallDisk(disk, 16, fmt::format("head -c 100000 /dev/zero > '{}/full'; {}", disk.string(), line));
    if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
    const std::string log = ReadFile(disk.string() + ".sh.log");
    EXPECT_EQ(*code, 1) << command << "\n" << log;
    EXPECT_THAT(log, HasSubstr("No space left on device")) << command;
    EXPECT_EQ(Sentences(log, " error: "), 1) << command << "\n" << log;
  }
}

TEST(Resources, FullDiskUnderTheLogOfAProcess) {
  const ScratchFolder folder;
  const std::string viewer = (test::BinaryFolder() / "viewer_headless").string();
  const test::ShellResult result =
      test::Shell(folder, fmt::format("timeout --preserve-status -s INT 2 {} --url memq:// --out {} 2> /dev/full",
                                      viewer, folder.Path("results")));
  EXPECT_EQ(result.exit_code, 0) << "ended by the signal, not by its log";
}

TEST(Resources, FullDiskUnderStandardError) {
  const ScratchFolder folder;
  const std::string early = folder.Write("early.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n");
  const std::string late = folder.Write("late.tum", "100 0 0 0 0 0 0 1\n101 1 0 0 0 0 0 1\n");
  const std::string evaluate = (test::BinaryFolder() / "evaluate").string();
  EXPECT_EQ(test::Shell(folder, fmt::format("{} {} --truth {} 2> /dev/full", evaluate, early, late)).exit_code, 1);
  const test::ShellResult run =
      test::Shell(folder, fmt::format("{} run '{}' --out {} 2> /dev/full", Plslam(), kWorld, folder.Path("run")));
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("completed"));
}

TEST(Resources, FullDiskUnderTheHistoryEndsNothing) {
  const WholeRun run;
  const fs::path disk = run.folder() / "disk";
  const auto code =
      OnASmallDisk(disk, 64,
                   fmt::format("{} run '{}' --out '{}' --set bus.history_dir='{}' --set bus.history_bytes=200000",
                               Plslam(), kWorld, run.out().string(), disk.string()));
  if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
  EXPECT_EQ(*code, 0) << ReadFile(run.folder() / "disk.sh.log");
  EXPECT_EQ(run.Summary()["tracked_frames"], 40);
}

TEST(Resources, UnwritableFoldersAreNamed) {
  WholeRun history, out;
  EXPECT_EQ(history.Run({"run", kWorld, "--set", "bus.history_dir=/proc/nowhere"}), 1);
  EXPECT_THAT(history.Logs(), HasSubstr("bus.history_dir: /proc/nowhere is not a writable folder"));
  const fs::path file = out.folder() / "a file";
  std::ofstream(file) << "in the way";
  const std::string log = (out.folder() / "log").string();
  launcher::ChildProcess child(test::BinaryFolder() / "plslam", {"run", kWorld, "--out", (file / "out").string()},
                               log);
  std::optional<launcher::ChildExit> end;
  ASSERT_TRUE(WholeRun::WaitFor([&] {
    end = child.Poll();
    return end.has_value();
  }));
  EXPECT_EQ(end->code, 1);
  EXPECT_THAT(ReadFile(log), HasSubstr("a file"));
  EXPECT_EQ(Sentences(ReadFile(log), "error: "), 1) << ReadFile(log);
}

void ExpectCleanInterrupt(WholeRun& run) {
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["reason"], "interrupted") << summary.dump(1);
  EXPECT_THAT(HalfWritten(run.out()), testing::IsEmpty());
  for (const char* name : {"player", "vo_process", "mapping_process", "loop_process", "viewer_headless"}) {
    EXPECT_EQ(run.PidOf(name), -1) << name;
  }
}

TEST(Resources, InterruptBeforeAllAreReady) {
  WholeRun run;
  run.Start({"run", kLongWorld});
  // The first process has been started; none has published a status.
  ASSERT_TRUE(WholeRun::WaitFor([&] { return fs::exists(run.out() / "logs" / "viewer.log"); }));
  ExpectCleanInterrupt(run);
  EXPECT_EQ(run.Summary()["frames"], 0);
}

TEST(Resources, InterruptAfterTheLastFrame) {
  WholeRun run;
  const RunWatcher watcher;
  run.Start({"run", kWorld, "--url", watcher.url()});
  ASSERT_TRUE(watcher.WaitForFrame(39)) << run.Logs();
  run.process().Signal(SIGINT);
  EXPECT_EQ(run.Wait(60), 0) << run.Logs();
  EXPECT_EQ(run.Summary()["frames"], 40);
  EXPECT_THAT(HalfWritten(run.out()), testing::IsEmpty());
}

TEST(Resources, PortOfTheRelayInUseIsOneSentence) {
  WholeRun first, second;
  first.Start({"relay", "--port", "0"});
  std::string port;
  ASSERT_TRUE(WholeRun::WaitFor([&] {
    const std::string log = first.Logs();
    const size_t at = log.find("tcpq://127.0.0.1:");
    const size_t end = at == std::string::npos ? at : log.find('\n', at);
    if (end != std::string::npos) port = log.substr(at + 17, end - at - 17);
    return !port.empty();
  })) << first.Logs();
  second.Start({"relay", "--port", port});
  EXPECT_EQ(second.Wait(20), 1) << second.Logs();
  EXPECT_THAT(second.Logs(), HasSubstr(port));
  EXPECT_EQ(Sentences(second.Logs(), "error: "), 1) << second.Logs();
}

}  // namespace
}  // namespace plslam
