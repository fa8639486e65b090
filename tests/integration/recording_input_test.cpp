// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "core/datasets/open_dataset.h"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"

namespace plslam::test {
namespace {

class RecordingInput : public testing::Test {
 protected:
  const ScratchFolder& folder() const { return folder_; }

  void WriteImages() {
    std::vector<ChosenFrame> frames(20);
    for (int i = 0; i < 20; ++i) frames[static_cast<size_t>(i)].index = i;
    WriteImageFolder(*OpenDataset("synthetic:room?frames=20&size=376x240", ""), frames, folder_.Path("images"));
  }

  /// The recording has the images, the camera, the times and the true poses of the folder.
  void ExpectTheContentOfTheFolder(const std::string& file) {
    const auto images = OpenDataset(folder_.Path("images"), ""), recording = OpenDataset(folder_.Path(file), "");
    ASSERT_EQ(recording->size(), images->size());
    EXPECT_EQ(recording->rig().baseline_m, images->rig().baseline_m);
    for (int i = 0; i < images->size(); ++i) {
      EXPECT_EQ(recording->t_ns(i), images->t_ns(i));
      ASSERT_TRUE(recording->GroundTruth(i) && images->GroundTruth(i));
      EXPECT_EQ(recording->GroundTruth(i)->matrix(), images->GroundTruth(i)->matrix()) << i;
      const StereoImages expected = images->Read(i), read = recording->Read(i);
      EXPECT_EQ(cv::countNonZero(expected.left != read.left), 0) << i;
      EXPECT_EQ(cv::countNonZero(expected.right != read.right), 0) << i;
    }
  }

  /// `n` frames are played with these options of `plslam run`.
  void ExpectTheTrajectoryOfTheFolder(const std::vector<std::string>& options, const std::string& file, int n) {
    std::string trajectories[2], truths[2];
    for (int k = 0; k < 2; ++k) {
      WholeRun run;
      std::vector<std::string> arguments{"run", folder_.Path(k == 0 ? "images" : file)};
      arguments.insert(arguments.end(), options.begin(), options.end());
      ASSERT_EQ(run.Run(arguments), 0) << run.Logs();
      trajectories[k] = run.Read("trajectory.tum");
      truths[k] = run.Read("groundtruth.tum");
    }
    EXPECT_EQ(std::count(trajectories[0].begin(), trajectories[0].end(), '\n'), n);
    EXPECT_EQ(trajectories[0], trajectories[1]);
    EXPECT_EQ(truths[0], truths[1]);
  }

 private:
  ScratchFolder folder_;
};

class McapInput : public RecordingInput {
 protected:
  void SetUp() override {
    if (!HasProgram("node") || !std::filesystem::exists(PLSLAM_MCAP_MODULES)) {
      GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
    }
    WriteImages();
  }

  /// As write_mcap.mjs takes its options.
  void Write(const std::string& options) {
    const std::string script = (SourceFolder() / "tests/mcap/write_mcap.mjs").string();
    const ShellResult written =
        Shell(folder(), fmt::format("node '{}' '{}' {} {} '{}'", script, PLSLAM_MCAP_MODULES, folder().Path("images"),
                                    folder().Path("a.mcap"), options));
    ASSERT_EQ(written.exit_code, 0) << written.error;
  }
};

TEST_F(McapInput, FileOfTheReferenceWriter) {
  Write("{}");
  ExpectTheContentOfTheFolder("a.mcap");
  EXPECT_TRUE(OpenDataset(folder().Path("a.mcap"), "")->Notes().empty());
  ExpectTheTrajectoryOfTheFolder({"--start", "2"}, "a.mcap", 18);
}

TEST_F(McapInput, OtherMessagesAndCompressions) {
  std::vector<std::string> all{R"({"odometry": true, "png": true})", R"({"encoding": "ros1"})",
                               R"({"encoding": "ros1", "odometry": true, "png": true, "unsorted": true})",
                               R"({"unsorted": true})"};
  for (const char* compression : {"zstd", "lz4"}) {
    if (HasProgram(compression)) all.push_back(fmt::format(R"({{"compression": "{}"}})", compression));
  }
  for (const std::string& options : all) {
    SCOPED_TRACE(options);
    Write(options);
    ExpectTheContentOfTheFolder("a.mcap");
    EXPECT_TRUE(OpenDataset(folder().Path("a.mcap"), "")->Notes().empty());
  }
}

// A slow disk or network: messages are logged after their stamps, those of the right camera later than the left ones.
TEST_F(McapInput, LateLoggingChangesNothing) {
  for (const std::string options :
       {R"({"late_ms": 30})", R"({"jitter_ms": 90})", R"({"encoding": "ros1", "late_ms": 90})",
        R"({"late_ms": 930, "jitter_ms": 70})"}) {
    SCOPED_TRACE(options);
    Write(options);
    ExpectTheContentOfTheFolder("a.mcap");
  }
  ExpectTheTrajectoryOfTheFolder({}, "a.mcap", 20);
}

// Parts of the index that a writer may omit, or that a killed recorder has not written.
TEST_F(McapInput, WithoutIndex) {
  for (
      const std::string options :
      {R"({"writer": {"useChunks": false}})", R"({"writer": {"useChunkIndex": false}})",
       R"({"writer": {"useMessageIndex": false}})", R"({"writer": {"repeatChannels": false}})",
       R"({"writer": {"repeatSchemas": false}})", R"({"cut": 0.999999})",
       R"({"writer": {"useChunks": false, "useStatistics": false, "repeatChannels": false, "repeatSchemas": false}})"}) {
    SCOPED_TRACE(options);
    Write(options);
    ExpectTheContentOfTheFolder("a.mcap");
    const auto notes = OpenDataset(folder().Path("a.mcap"), "")->Notes();
    ASSERT_EQ(notes.remarks.size() + notes.warnings.size(), 1U);
    EXPECT_THAT(notes.warnings.empty() ? notes.remarks.front() : notes.warnings.front(),
                testing::AllOf(testing::HasSubstr("were read to find the messages, which took"),
                               testing::HasSubstr("`mcap recover`")));
  }
}

TEST_F(McapInput, StopAndBounceAsForAnImageFolder) {
  Write(R"({"writer": {"useMessageIndex": false}, "unsorted": true})");
  ExpectTheTrajectoryOfTheFolder({"--stop", "8", "--bounce"}, "a.mcap", 15);
}

TEST_F(McapInput, CutOffFilesPlayWithAWarning) {
  Write(R"({"cut": 0.5})");
  WholeRun run;
  ASSERT_EQ(
      run.Run({"run", folder().Path("a.mcap"), "--topics", "/stereo/left/image_raw", "/stereo/right/image_raw"}), 0)
      << run.Logs();
  const std::string trajectory = run.Read("trajectory.tum");
  const auto n = std::count(trajectory.begin(), trajectory.end(), '\n');
  EXPECT_GE(n, 8);
  EXPECT_LE(n, 11);
  EXPECT_THAT(run.Summary()["warnings"].dump(), testing::HasSubstr("recording_without_index"));
  EXPECT_THAT(run.Read("logs/player.log"), testing::HasSubstr("belong to a record that is truncated"));
}

// Messages of Foxglove's serializer in a database of Python's SQLite.
TEST_F(McapInput, BagsOfRos2AsOfTheFolder) {
  Write(R"({"writer": {"useChunks": false}})");
  const std::string script = (SourceFolder() / "tests/bag/write_db3.py").string();
  std::vector<std::string> forms{"", "split"};
  if (HasProgram("zstd")) forms.insert(forms.end(), {"zstd-files split", "zstd-messages"});
  for (const std::string& form : forms) {
    SCOPED_TRACE(form);
    std::filesystem::remove_all(folder().Path("bag"));
    const ShellResult written = Shell(
        folder(), fmt::format("python3 '{}' {} {} {}", script, folder().Path("a.mcap"), folder().Path("bag"), form));
    ASSERT_EQ(written.exit_code, 0) << written.error;
    ExpectTheContentOfTheFolder("bag");
    EXPECT_TRUE(OpenDataset(folder().Path("bag"), "")->Notes().empty());
  }
  ExpectTheTrajectoryOfTheFolder({"--start", "2"}, "bag", 18);
}

class BagInput : public RecordingInput {
 protected:
  // Debian's modules are those of Debian's Python.
  static constexpr const char* kPython = "/usr/bin/python3";

  void SetUp() override {
    const ShellResult found =
        Shell(folder(), fmt::format("{} -c 'import rosbag, sensor_msgs, geometry_msgs, nav_msgs, roslz4'", kPython));
    if (found.exit_code != 0) {
      GTEST_SKIP() << "python3-rosbag, -sensor-msgs, -geometry-msgs, -nav-msgs or -roslz4 is missing";
    }
    WriteImages();
  }

  /// As write_bag.py takes its options.
  void Write(const std::string& options) {
    const std::string script = (SourceFolder() / "tests/bag/write_bag.py").string();
    const ShellResult written = Shell(
        folder(),
        fmt::format("{} '{}' {} {} {}", kPython, script, folder().Path("images"), folder().Path("a.bag"), options));
    ASSERT_EQ(written.exit_code, 0) << written.error;
  }
};

TEST_F(BagInput, FileOfTheRosWriter) {
  for (const char* options : {"none", "bz2 png odometry", "lz4 png unsorted"}) {
    SCOPED_TRACE(options);
    Write(options);
    ExpectTheContentOfTheFolder("a.bag");
    EXPECT_TRUE(OpenDataset(folder().Path("a.bag"), "")->Notes().empty());
  }
  ExpectTheTrajectoryOfTheFolder({"--start", "2", "--stop", "10", "--bounce"}, "a.bag", 15);
}

TEST_F(BagInput, UnclosedFileAfterAKill) {
  Write("none killed");
  ExpectTheContentOfTheFolder("a.bag");
  const auto notes = OpenDataset(folder().Path("a.bag"), "")->Notes();
  ASSERT_EQ(notes.remarks.size(), 1U);
  EXPECT_THAT(notes.remarks.front(), testing::HasSubstr("has no index because it was not closed"));
}

}  // namespace
}  // namespace plslam::test
