#include "tools/plslam/run_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "tests/support/text_file.h"

namespace plslam {
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

TEST(FilesToWrite, FolderThatIsNotThereIsOneSentence) {
  const ScratchFolder folder;
  RunOptions options;
  options.save_map = folder.Path("no/x.plmap");
  EXPECT_THAT(WhyNot(options), HasSubstr("x.plmap: there is no folder " + folder.Path("no")));
  options.save_map = folder.Path("");
  EXPECT_THAT(WhyNot(options), HasSubstr("is a folder, not a file to write"));
  options.save_map = folder.Path("x.plmap");
  EXPECT_EQ(WhyNot(options), "");
  options.save_map = "/proc/x.plmap";
  EXPECT_THAT(WhyNot(options), testing::AnyOf(HasSubstr("nothing can be written there"), ""))
      << "root may write anywhere, as far as access() knows";
}

TEST(FilesToWrite, WhatIsReadIsNotWritten) {
  const ScratchFolder folder;
  RunOptions options;
  options.dataset = folder.Write("a.lcm", "log");
  options.record = folder.Path("./a.lcm");
  EXPECT_THAT(WhyNot(options), HasSubstr("this run reads that file, and would destroy it"));
  options.record = folder.Write("old.lcm", "another");
  EXPECT_EQ(WhyNot(options), "") << "an old recording is replaced";
  options.map = options.record;
  EXPECT_NE(WhyNot(options), "");
  options.record.clear();
  options.save_map = options.map;
  EXPECT_EQ(WhyNot(options), "") << "a map may be saved over the one that the run went on from";
}

TEST(OldOutputs, OnlyWhatARunWritesAndWhatIsOldGoes) {
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

// What a process has said within the first milliseconds of a run stays.
TEST(OldOutputs, FilesThatAreWrittenAtOnceAreOfThisRun) {
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
}  // namespace plslam
