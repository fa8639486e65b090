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

  void ExpectTheTrajectoryOfTheFolder(const std::string& file) {
    std::string trajectories[2], truths[2];
    for (int k = 0; k < 2; ++k) {
      WholeRun run;
      ASSERT_EQ(run.Run({"run", folder_.Path(k == 0 ? "images" : file), "--start", "2"}), 0) << run.Logs();
      trajectories[k] = run.Read("trajectory.tum");
      truths[k] = run.Read("groundtruth.tum");
    }
    EXPECT_EQ(std::count(trajectories[0].begin(), trajectories[0].end(), '\n'), 18);
    EXPECT_EQ(trajectories[0], trajectories[1]);
    EXPECT_EQ(truths[0], truths[1]);
  }

 private:
  ScratchFolder folder_;
};

TEST_F(RecordingInput, McapOfTheFormatsOwnWriter) {
  if (!HasProgram("node") || !std::filesystem::exists(PLSLAM_MCAP_MODULES)) {
    GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
  }
  WriteImages();
  const std::string script = (SourceFolder() / "tests/mcap/write_mcap.mjs").string();
  const ShellResult written = Shell(folder(), fmt::format("node '{}' '{}' {} {}", script, PLSLAM_MCAP_MODULES,
                                                          folder().Path("images"), folder().Path("a.mcap")));
  ASSERT_EQ(written.exit_code, 0) << written.error;
  ExpectTheContentOfTheFolder("a.mcap");
  ExpectTheTrajectoryOfTheFolder("a.mcap");
}

TEST_F(RecordingInput, BagOfRosOwnWriter) {
  // Debian's modules are those of Debian's Python.
  const std::string python = "/usr/bin/python3";
  const ShellResult found = Shell(folder(), python + " -c 'import rosbag, sensor_msgs, geometry_msgs, roslz4'");
  if (found.exit_code != 0) GTEST_SKIP() << "python3-rosbag, -sensor-msgs, -geometry-msgs or -roslz4 is missing";
  WriteImages();
  const std::string script = (SourceFolder() / "tests/bag/write_bag.py").string();
  for (const std::string compression : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    const ShellResult written =
        Shell(folder(), fmt::format("{} '{}' {} {} {}", python, script, folder().Path("images"),
                                    folder().Path("a.bag"), compression));
    ASSERT_EQ(written.exit_code, 0) << written.error;
    ExpectTheContentOfTheFolder("a.bag");
  }
  ExpectTheTrajectoryOfTheFolder("a.bag");
}

}  // namespace
}  // namespace plslam::test
