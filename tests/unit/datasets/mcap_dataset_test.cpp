// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/recording_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"
#include "tests/unit/datasets/mcap_file.h"

namespace plslam {
namespace {

using test::ErrorOf;
using test::MakeMcapFile;
using testing::AllOf;
using testing::HasSubstr;

class McapDataset : public test::RecordingFileTest {
 protected:
  McapDataset() : RecordingFileTest("a.mcap") {}
};

TEST_F(McapDataset, ChunksOfEachCompressionInAnyOrder) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    for (const bool unsorted : {false, true}) {
      MakeMcapFile(path(), {.compression = compression, .unsorted = unsorted});
      ExpectItsFrames(compression);
    }
  }
}

TEST_F(McapDataset, RigOfCameraInfo) {
  MakeMcapFile(path());
  const RigCalibration rig = OpenDataset(path(), "")->rig();
  EXPECT_EQ(rig.left.fx_px, 40.0);
  EXPECT_EQ(rig.left.cy_px, 16.0);
  EXPECT_EQ(rig.left.model, "radtan");
  EXPECT_EQ(rig.left.distortion, std::vector<double>({-0.28, 0.07, 0.0002, 1.8e-5, 0.0}));
  EXPECT_EQ(rig.baseline_m, 0.125);
  EXPECT_EQ(rig.right.T_b_cam.translation(), Eigen::Vector3d(0.125, 0.0, 0.0));
  EXPECT_EQ(rig.rate_hz, 10.0);
  MakeMcapFile(path(), {.left = "/left/image_rect", .right = "/right/image_rect"});
  EXPECT_EQ(OpenDataset(path(), "")->rig().left.model, "pinhole") << "the images are rectified";
  MakeMcapFile(path(), {.p_right = 0.0});
  EXPECT_THAT(Error(), HasSubstr("camera_info has no baseline"));
}

TEST_F(McapDataset, TopicsAreFoundOrGiven) {
  MakeMcapFile(path(), {.left = "/a/image", .right = "/b/image"});
  EXPECT_THAT(Error(), AllOf(HasSubstr(path() + ": no two image topics"), HasSubstr("are /a/image, /b/image")));
  EXPECT_EQ(OpenDataset(path() + "?left=/a/image&right=/b/image&truth=/ground_truth", "")->size(), 3);
  EXPECT_THAT(Error("?left=/a/image&right=/c"), HasSubstr("has no images on the topic right=/c"));
  EXPECT_THAT(Error("?left=/a/image"), HasSubstr("given together"));
  EXPECT_THAT(Error("?side=/a/image"), HasSubstr("'side=/a/image' is none of left=TOPIC"));
}

TEST_F(McapDataset, ColourBecomesGreyAndOtherEncodingsAreNamed) {
  MakeMcapFile(path(), {.encoding = "rgb8"});
  EXPECT_EQ(OpenDataset(path(), "")->Read(1).left.at<uint8_t>(5, 7), test::TinyPixel(1, 0, 7, 5));
  MakeMcapFile(path(), {.encoding = "yuv422"});
  EXPECT_THAT(Error(), AllOf(HasSubstr("frame 0: /cam0/image_raw: "), HasSubstr("'yuv422', not as mono8")));
}

TEST_F(McapDataset, CutOffDamagedAndForeignFilesAreTold) {
  MakeMcapFile(path());
  const std::string whole = test::ReadText(path());
  test::WriteText(path(), whole.substr(0, whole.size() / 2));
  EXPECT_THAT(Error(), HasSubstr(path() + ": does not end as MCAP files do"));
  test::WriteText(path(), whole.substr(0, 9));
  EXPECT_THAT(Error(), HasSubstr("too short"));
  std::string damaged = whole;
  damaged[200] = static_cast<char>(damaged[200] ^ 1);
  test::WriteText(path(), damaged);
  EXPECT_THAT(Error(), HasSubstr("the checksum of a chunk is wrong"));
  damaged = whole;
  damaged[whole.size() - 60] = static_cast<char>(damaged[whole.size() - 60] ^ 1);
  test::WriteText(path(), damaged);
  EXPECT_THAT(Error(), HasSubstr("the checksum of its summary is wrong"));
  test::WriteText(path(), "#ROSBAG V2.0\n and more");
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path(), "mcap"); }), HasSubstr("too short"));
  test::WriteText(path(), "#ROSBAG V2.0\n" + std::string(100, 'x'));
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path(), "mcap"); }), HasSubstr("is no MCAP file"));
}

}  // namespace
}  // namespace plslam
