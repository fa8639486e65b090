// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "core/config/config.h"
#include "core/io/maps/map_camera.h"
#include "core/io/maps/map_file.h"
#include "tests/support/text_file.h"
#include "tests/unit/map_file/stored_maps.h"
#include "tools/plslam/run_files.h"

namespace plslam::launcher {
namespace {

using std::filesystem::exists;
using testing::HasSubstr;

std::string WhyNot(const RunOptions& options) {
  try {
    CheckFilesToWrite(options);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST(FilesToWrite, MissingFolderIsOneSentence) {
  const ScratchFolder folder;
  RunOptions options;
  options.save_map = folder.Path("no/x.plmap");
  EXPECT_THAT(WhyNot(options), HasSubstr("x.plmap: the folder " + folder.Path("no")));
  options.save_map = folder.Path("");
  EXPECT_THAT(WhyNot(options), HasSubstr("is a folder, not a file to write"));
  options.save_map = folder.Path("x.plmap");
  EXPECT_EQ(WhyNot(options), "");
  options.video = folder.Path("no/x.mp4");
  EXPECT_THAT(WhyNot(options), HasSubstr("--video " + folder.Path("no/x.mp4") + ": the folder"));
  options.video.clear();
  options.save_map = "/proc/x.plmap";
  EXPECT_THAT(WhyNot(options), testing::AnyOf(HasSubstr("cannot be written"), ""))
      << "root may write anywhere, as far as access() knows";
}

TEST(FilesToWrite, InputFileIsNotOverwritten) {
  const ScratchFolder folder;
  RunOptions options;
  options.dataset = folder.Write("a.lcm", "log");
  options.record = folder.Path("./a.lcm");
  EXPECT_THAT(WhyNot(options), HasSubstr("this run reads that file and would overwrite it"));
  options.record = folder.Write("old.lcm", "another");
  EXPECT_THAT(WhyNot(options), HasSubstr("exists already"));
  options.force = true;
  EXPECT_EQ(WhyNot(options), "");
  options.map = options.record;
  EXPECT_NE(WhyNot(options), "");
  options.record.clear();
  options.save_map = options.map;
  EXPECT_EQ(WhyNot(options), "") << "a map may be saved over the one that the run went on from";
  options.dataset = folder.Path("a.lcm?left=/a&right=/b");
  options.save_map = folder.Path("a.lcm");
  EXPECT_THAT(WhyNot(options), HasSubstr("--save-map")) << "a recording of which topics are named";
}

TEST(Configuration, FileAppliesUnlessTheCommandLineOverrides) {
  const ScratchFolder folder;
  RunOptions options;
  options.config_file = folder.Write("a.yaml",
                                     "bus:\n  url: udpm://239.255.76.67:7700?ttl=0\n  prefix: team/\n"
                                     "player:\n  kind: images\n  pace: realtime\n");
  options.prefix = "mine/";
  ReadConfiguration(&options);
  EXPECT_EQ(options.url, "udpm://239.255.76.67:7700?ttl=0");
  EXPECT_EQ(options.prefix, "mine/");
  EXPECT_EQ(options.kind, "images");
  EXPECT_EQ(options.pace, "realtime");
}

TEST(Configuration, BusAndPlayerKeysAreCheckedFirst) {
  const ScratchFolder folder;
  RunOptions options;
  options.config_file = folder.Write("a.yaml", "player:\n  paces: realtime\n");
  EXPECT_THAT([&] { ReadConfiguration(&options); }, testing::ThrowsMessage<ConfigError>(HasSubstr("'player.paces'")));
  options.config_file = folder.Write("b.yaml", "bus:\n  map_prefix: team/\n");
  EXPECT_THAT([&] { ReadConfiguration(&options); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("--url or bus.url")));
}

TEST(MapToContinue, ReadableMapOfAnyCameraIsAccepted) {
  const ScratchFolder folder;
  RunOptions options;
  options.dataset = "synthetic:room?size=160x120&frames=4";
  const auto why_not = [&] {
    try {
      CheckMapToContinue(options);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(why_not(), "") << "none is asked for";
  options.map = folder.Path("a.plmap");
  StoredMap stored = test::RandomStoredMap(1, 20);
  stored.rig = CameraBytes({400.0, 320.0, 240.0, 0.12, 640, 480});
  WriteMapFile(options.map, stored);
  EXPECT_EQ(why_not(), "");
  stored.rig.clear();
  WriteMapFile(options.map, stored);
  EXPECT_THAT(why_not(), HasSubstr("a.plmap: does not contain the camera with which it was made"));
  std::filesystem::resize_file(options.map, std::filesystem::file_size(options.map) - 1);
  EXPECT_THAT(why_not(), HasSubstr("it was truncated or damaged"));
  folder.Write("a.plmap", "hello");
  EXPECT_THAT(why_not(), HasSubstr("a.plmap: is not a map file"));
}

TEST(OutputFolderTest, RunWithoutResultsLeavesNoFolder) {
  const ScratchFolder folder;
  folder.Write("notes.txt", "of the user");
  {
    const OutputFolder made(folder.Path("a/b/"));
    folder.Write("a/b/logs/vo.log", "vo: error: no");
    EXPECT_FALSE(made.has_results());
  }
  EXPECT_FALSE(exists(folder.Path("a")));
  EXPECT_TRUE(exists(folder.Path("notes.txt")));
  {
    OutputFolder kept(folder.Path("a/b"));
    kept.Keep();
    folder.Write("a/b/logs/vo.log", "");
    folder.Write("a/b/summary.json", "{}");
  }
  EXPECT_TRUE(exists(folder.Path("a/b/logs/vo.log")));
  { EXPECT_TRUE(OutputFolder(folder.Path("a/b")).has_results()); }
  EXPECT_TRUE(exists(folder.Path("a/b/summary.json"))) << "of a run before";
}

TEST(OutputFolderTest, FolderOfAnotherRunIsRefused) {
  const ScratchFolder folder;
  OutputFolder first(folder.Path("a"));
  folder.Write("a/logs/vo.log", "of the first");
  EXPECT_THAT([&] { OutputFolder(folder.Path("a")); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("is writing its results there")));
  EXPECT_TRUE(exists(folder.Path("a/logs/vo.log")));
}

TEST(OldOutputs, OnlyOldOutputsAreRemoved) {
  const ScratchFolder folder;
  RunOptions options;
  options.out = folder.Path("out");
  options.record = folder.Path("run.lcm");
  const std::vector<std::string> old{"out/trajectory.kitti", "out/poses.csv", "out/overlays/000010.png",
                                     "out/logs/loop.log", "run.lcm.2"};
  std::filesystem::create_directories(options.out / "overlays");
  std::filesystem::create_directories(options.out / "logs");
  for (const std::string& file : old) folder.Write(file, "old");
  folder.Write("out/notes.txt", "of the user");
  folder.Write("run.lcm", "of the recorder, which replaces it");
  const auto after = std::filesystem::file_time_type::clock::now() + std::chrono::hours(1);
  RemoveOldOutputs(options, after - std::chrono::hours(2));
  for (const std::string& file : old) EXPECT_TRUE(exists(folder.Path(file))) << file << " is of this run";
  RemoveOldOutputs(options, after);
  for (const std::string& file : old) EXPECT_FALSE(exists(folder.Path(file))) << file;
  EXPECT_TRUE(exists(folder.Path("out/notes.txt")));
  EXPECT_TRUE(exists(folder.Path("run.lcm")));
}

// Files that a process writes within the first milliseconds of a run are kept.
TEST(OldOutputs, NewlyWrittenFilesBelongToThisRun) {
  const ScratchFolder folder;
  RunOptions options;
  options.out = folder.Path("out");
  std::filesystem::create_directories(options.out / "logs");
  for (int i = 0; i < 200; ++i) {
    const auto began = FileTimeNow(options);
    folder.Write("out/logs/mapping.log", "");
    RemoveOldOutputs(options, began);
    ASSERT_TRUE(exists(folder.Path("out/logs/mapping.log"))) << i;
  }
  EXPECT_FALSE(exists(folder.Path("out/.began")));
}

}  // namespace
}  // namespace plslam::launcher
