// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/node/surfaces_on_disk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/text_file.h"

namespace plslam::dense {
namespace {

using testing::HasSubstr;

class SurfacesOnDiskTest : public testing::Test {
 protected:
  DenseOptions Options(const std::string& state_file, const std::string& map_file = "") const {
    DenseOptions options;
    options.out = folder_.Path("out");
    options.state_file = state_file;
    options.map_file = map_file;
    return options;
  }
  void Fuse(SurfacesOnDisk& disk, int n) {
    for (int i = 0; i < n; ++i) disk.Fused(surfaces_, map_);
  }

  const ScratchFolder folder_;
  const std::string state_ = folder_.Path("state.surfaces");
  const DenseMap surfaces_{0.05, 0.0};
  const Map map_;
};

TEST_F(SurfacesOnDiskTest, StateIsWrittenNowAndThen) {
  SurfacesOnDisk disk(Options(state_));
  EXPECT_TRUE(std::filesystem::is_directory(folder_.Path("out")));
  disk.KeepState(surfaces_, map_);
  Fuse(disk, 9);
  EXPECT_FALSE(std::filesystem::exists(state_));
  Fuse(disk, 1);
  EXPECT_TRUE(std::filesystem::remove(state_));
  disk.KeepState(surfaces_, map_);
  EXPECT_FALSE(std::filesystem::exists(state_)) << "nothing was fused since";
  Fuse(disk, 1);
  disk.KeepState(surfaces_, map_);
  EXPECT_TRUE(std::filesystem::exists(state_));
  EXPECT_EQ(disk.Failures(), "");
}

TEST_F(SurfacesOnDiskTest, StateIsContinuedBeforeASavedMap) {
  const std::string saved = folder_.Path("room.plmap.surfaces");
  EXPECT_EQ(SurfacesOnDisk(Options("")).Earlier(), "");
  SurfacesOnDisk disk(Options(state_, saved));
  EXPECT_EQ(disk.Earlier(), saved);
  Fuse(disk, 10);
  EXPECT_EQ(disk.Earlier(), state_);
}

TEST_F(SurfacesOnDiskTest, FailuresOfResultsAreKept) {
  const std::string nowhere = folder_.Path("no/such/folder/");
  SurfacesOnDisk disk(Options(nowhere + "state"));
  Fuse(disk, 20);
  EXPECT_EQ(disk.Failures(), "") << "a state that is not written is no error";
  disk.SetFailure("the disk is full");
  EXPECT_EQ(disk.Failures(), "the disk is full");
  EXPECT_NE(disk.SaveBeside(nowhere + "room.plmap", &surfaces_, map_), "");
  EXPECT_EQ(disk.failure(), "the disk is full");
  EXPECT_THAT(disk.Failures(), HasSubstr("the disk is full; "));
  EXPECT_THAT(disk.Failures(), HasSubstr("room.plmap.surfaces"));
  disk.SetFailure("");
  EXPECT_THAT(disk.Failures(), HasSubstr("room.plmap.surfaces"));
}

TEST_F(SurfacesOnDiskTest, SavedSurfacesStandBesideTheMap) {
  SurfacesOnDisk disk(Options(""));
  EXPECT_EQ(disk.SaveBeside(folder_.Path("room.plmap"), &surfaces_, map_), "");
  EXPECT_TRUE(std::filesystem::exists(folder_.Path("room.plmap.surfaces")));
  EXPECT_EQ(disk.Failures(), "");
}

}  // namespace
}  // namespace plslam::dense
