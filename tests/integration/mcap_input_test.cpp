// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "core/datasets/open_dataset.h"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"

namespace plslam::test {
namespace {

TEST(McapInput, ARecordingOfTheFormatsOwnWriterGivesTheTrajectoryOfTheFolder) {
  if (!HasProgram("node") || !std::filesystem::exists(PLSLAM_MCAP_MODULES)) {
    GTEST_SKIP() << "no node, or its packages could not be fetched at the build";
  }
  const ScratchFolder folder;
  std::vector<ChosenFrame> frames;
  for (int i = 0; i < 20; ++i) frames.push_back({i});
  WriteImageFolder(*OpenDataset("synthetic:room?frames=20&size=376x240", ""), frames, folder.Path("images"));
  const std::string script = (SourceFolder() / "tests/mcap/write_mcap.mjs").string();
  const ShellResult written = Shell(folder, fmt::format("node '{}' '{}' {} {}", script, PLSLAM_MCAP_MODULES,
                                                        folder.Path("images"), folder.Path("a.mcap")));
  ASSERT_EQ(written.exit_code, 0) << written.error;

  const auto images = OpenDataset(folder.Path("images"), ""), recording = OpenDataset(folder.Path("a.mcap"), "");
  ASSERT_EQ(recording->size(), images->size());
  EXPECT_EQ(recording->rig().baseline_m, images->rig().baseline_m);
  for (int i = 0; i < images->size(); ++i) {
    EXPECT_EQ(recording->t_ns(i), images->t_ns(i));
    ASSERT_TRUE(recording->GroundTruth(i) && images->GroundTruth(i));
    EXPECT_EQ(recording->GroundTruth(i)->matrix(), images->GroundTruth(i)->matrix()) << i;
  }
  std::string trajectories[2], truths[2];
  for (int k = 0; k < 2; ++k) {
    WholeRun run;
    ASSERT_EQ(run.Run({"run", k == 0 ? folder.Path("images") : folder.Path("a.mcap"), "--start", "2"}), 0)
        << run.Logs();
    trajectories[k] = run.Read("trajectory.tum");
    truths[k] = run.Read("groundtruth.tum");
  }
  EXPECT_EQ(std::count(trajectories[0].begin(), trajectories[0].end(), '\n'), 18);
  EXPECT_EQ(trajectories[0], trajectories[1]);
  EXPECT_EQ(truths[0], truths[1]);
}

}  // namespace
}  // namespace plslam::test
