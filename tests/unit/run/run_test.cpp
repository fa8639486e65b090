// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/run/result_files.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr unsigned kAll = run_content::kSummary | run_content::kTrajectory | run_content::kLive |
                          run_content::kKeyframes | run_content::kTruth | run_content::kCovariances |
                          run_content::kFrames;

/// The 36 numbers of `scale` times the identity.
std::string Identity(int scale) {
  std::string row;
  for (int i = 0; i < 36; ++i) row += i % 7 == 0 ? " " + std::to_string(scale) : " 0";
  return row;
}

class ReadRunTest : public testing::Test {
 protected:
  void Write(const std::string& name, const std::string& text) { folder_.Write(name, text); }
  plslam::Run Read(unsigned content) const { return ReadRun(folder_.Path(""), content); }
  std::string FailureOf(unsigned content) const {
    try {
      Read(content);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  ScratchFolder folder_;
};

TEST_F(ReadRunTest, EmptyFolderHasNothing) {
  const plslam::Run run = Read(kAll);
  EXPECT_FALSE(run.summary || run.trajectory || run.live || run.keyframes || run.truth || run.covariance ||
               run.motion_covariance || run.frames || run.map);
}

// The launcher reports a full or blocked folder itself.
TEST_F(ReadRunTest, FolderInPlaceOfAFileIsNoFile) {
  std::filesystem::create_directories(folder_.Path(result_file::kTrajectory.tum));
  EXPECT_FALSE(Read(run_content::kTrajectory).trajectory);
}

TEST_F(ReadRunTest, EachFileFillsItsMember) {
  for (const auto& [name, t] :
       {std::pair(result_file::kTrajectory.tum, 1), std::pair(result_file::kLiveTrajectory, 2),
        std::pair(result_file::kKeyframes.tum, 3), std::pair(result_file::kTruth, 4)}) {
    Write(name, std::to_string(t) + " 0 0 0 0 0 0 1\n");
  }
  Write(result_file::kSummary, R"({"frames": 5})");
  const plslam::Run run = Read(kAll);
  EXPECT_EQ(run.summary->at("frames"), 5);
  EXPECT_EQ(run.trajectory->at(0).t_ns, 1'000'000'000);
  EXPECT_EQ(run.live->at(0).t_ns, 2'000'000'000);
  EXPECT_EQ(run.keyframes->at(0).t_ns, 3'000'000'000);
  EXPECT_EQ(run.truth->at(0).t_ns, 4'000'000'000);
}

TEST_F(ReadRunTest, CovariancesOfPosesAndMotions) {
  Write(result_file::kCovariances, "1" + Identity(1) + "\n");
  Write(result_file::kMotionCovariances, "2" + Identity(4) + "\n");
  const plslam::Run run = Read(kAll);
  EXPECT_EQ(run.covariance->at(0).covariance, Matrix6d::Identity());
  EXPECT_EQ(run.motion_covariance->at(0).covariance, 4.0 * Matrix6d::Identity());
  EXPECT_EQ(run.motion_covariance->at(0).t_ns, 2'000'000'000);
}

TEST_F(ReadRunTest, FramesAreRowsOfTheTable) {
  Write(result_file::kFrameTable, "frame_id,t_s,state,n_points\n7,1.5,lost,20\n");
  const FrameTable table = *Read(run_content::kFrames).frames;
  EXPECT_THAT(table.columns, ElementsAre("frame_id", "t_s", "state", "n_points"));
  ASSERT_EQ(table.rows.size(), 1U);
  EXPECT_EQ(table.rows[0].t_ns, 1'500'000'000);
  EXPECT_THAT(table.rows[0].values, ElementsAre("7", "1.5", "lost", "20"));
}

TEST_F(ReadRunTest, RowWithMissingColumnIsRefused) {
  Write(result_file::kFrameTable, "frame_id,t_s,state,n_points\n7,1.5,lost\n");
  EXPECT_THAT(FailureOf(run_content::kFrames), HasSubstr("poses.csv:2: does not have the columns"));
}

TEST_F(ReadRunTest, OnlyRequestedFilesAreRead) {
  Write(result_file::kSummary, "{");
  Write(result_file::kLiveTrajectory, "garbage\n");
  EXPECT_FALSE(Read(run_content::kTrajectory).live);
  EXPECT_THAT(FailureOf(run_content::kSummary), HasSubstr("summary.json: is not readable as JSON"));
  EXPECT_THAT(FailureOf(run_content::kLive), HasSubstr("trajectory_live.tum:1:"));
}

TEST_F(ReadRunTest, NeitherMapNorPoses) {
  EXPECT_THAT(FailureOf(run_content::kMap | run_content::kTrajectory), HasSubstr("has neither a map (.plmap)"));
  Write("a.plmap", "");
  Write("b.plmap", "");
  EXPECT_THAT(FailureOf(run_content::kMap), HasSubstr("has 2 maps"));
}

}  // namespace
}  // namespace plslam
