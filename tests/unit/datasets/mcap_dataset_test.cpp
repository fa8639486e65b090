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

TEST_F(McapDataset, CameraInfoOfBinnedImages) {
  MakeMcapFile(path(), {.info_scale = 2, .binning = 2});
  const RigCalibration rig = OpenDataset(path(), "")->rig();
  EXPECT_EQ(rig.left.fx_px, 40.0);
  EXPECT_EQ(rig.left.cy_px, 16.0);
  EXPECT_EQ(rig.baseline_m, 0.125);
  ExpectFrames(3, "binned");
  MakeMcapFile(path(), {.binning = 2});
  EXPECT_EQ(OpenDataset(path(), "")->rig().left.fx_px, 40.0) << "a driver that bins in the camera";
  MakeMcapFile(path(), {.info_scale = 2});
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path(), ""); }), HasSubstr("but the images have")) << "when it is opened";
}

TEST_F(McapDataset, CameraInfoInDoubtIsNotedOrRefused) {
  MakeMcapFile(path(), {.p_right = -500.0});
  EXPECT_THAT(Note(),
              AllOf(HasSubstr("camera_info: the cameras are 12.5 m apart"), HasSubstr("?camera=camera.yaml")));
  MakeMcapFile(path(), {.skew_right = -2.0});
  EXPECT_THAT(Error(),
              AllOf(HasSubstr("P[1] of the right camera_info = -2 is not 0"), HasSubstr("?camera=camera.yaml")));
}

TEST_F(McapDataset, TopicsAreFoundOrGiven) {
  MakeMcapFile(path(), {.left = "/a/image", .right = "/b/image"});
  EXPECT_THAT(Error(), AllOf(HasSubstr(path() + ": no two image topics"), HasSubstr("are /a/image, /b/image")));
  EXPECT_EQ(OpenDataset(path() + "?left=/a/image&right=/b/image&truth=/ground_truth", "")->size(), 3);
  EXPECT_THAT(Error("?left=/a/image&right=/c"), HasSubstr("has no images on the topic right=/c"));
  EXPECT_THAT(Error("?left=/a/image"), HasSubstr("given together"));
  EXPECT_THAT(Error("?side=/a/image"), HasSubstr("'side=/a/image' is not one of left=TOPIC"));
}

TEST_F(McapDataset, ColourBecomesGrey) {
  MakeMcapFile(path(), {.encoding = "rgb8"});
  EXPECT_EQ(OpenDataset(path(), "")->Read(1).left.at<uint8_t>(5, 7), test::TinyPixel(1, 0, 7, 5));
}

TEST_F(McapDataset, OtherEncodingsAreRefusedAtOpening) {
  MakeMcapFile(path(), {.encoding = "yuv411"});
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path(), ""); }),
              HasSubstr(path() + ": /cam0/image_raw: its images are encoded as 'yuv411', not as mono"));
}

TEST_F(McapDataset, TenBitsInSixteenAreStretched) {
  MakeMcapFile(path(), {.encoding = "mono16"});
  const auto dataset = OpenDataset(path(), "");
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(dataset->Read(i).left.at<uint8_t>(5, 7), test::TinyPixel(i, 0, 7, 5), 1);
    EXPECT_NEAR(dataset->Read(i).right.at<uint8_t>(5, 7), test::TinyPixel(i, 1, 7, 5), 1);
  }
  EXPECT_THAT(Note(), AllOf(HasSubstr("16-bit images have values up to "),
                            HasSubstr(", as with 10 bits: 1023 is mapped to white")));
}

TEST_F(McapDataset, ExistingTopicsAreListed) {
  MakeMcapFile(path(), {.image_type = "PointCloud2"});
  EXPECT_THAT(Error(), AllOf(HasSubstr(path() + ": has nothing to play: it has no ROS images"),
                             HasSubstr("its topics are /cam0/camera_info (sensor_msgs/msg/CameraInfo in cdr), ")));
  MakeMcapFile(path(), {.image_type = "UnknownImage"});
  EXPECT_THAT(Error(), HasSubstr("but /cam0/image_raw (sensor_msgs/msg/UnknownImage in cdr)"));
}

TEST_F(McapDataset, MissingCalibrationNamesTheOption) {
  MakeMcapFile(path(), {.p_right = 0.0});
  EXPECT_THAT(Error(), HasSubstr("give a camera file (docs/datasets.md), FILE?camera=camera.yaml"));
}

TEST_F(McapDataset, CutOffAndUnclosedFilesPlayIntactParts) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    MakeMcapFile(path(), {.compression = compression});
    const std::string whole = test::ReadText(path());
    test::WriteText(path(), whole.substr(0, whole.size() - 20));
    ExpectFrames(3, compression);
    EXPECT_THAT(Note(),
                AllOf(HasSubstr("has no index, because its recorder did not close it or it is truncated: all of "
                                "its 0.0 MB were read to find the messages, which took 0.0 s"),
                      HasSubstr("`mcap recover` writes an index")));
  }
  MakeMcapFile(path());
  const std::string whole = test::ReadText(path());
  test::WriteText(path(), whole.substr(0, whole.size() / 2));
  ExpectFrames(1, "half");
  EXPECT_THAT(Note(), testing::ContainsRegex("its last [0-9]+ bytes are not played because they belong to a record "
                                             "that is truncated \\([0-9]+ bytes are missing\\)"));
  test::WriteText(path(), whole.substr(0, 9));
  EXPECT_THAT(Error(), AllOf(HasSubstr("it has no topics at all"), HasSubstr("its last 1 bytes are not played")));
}

TEST_F(McapDataset, DamagedFilesPlayTheirIntactParts) {
  MakeMcapFile(path());
  const std::string whole = test::ReadText(path());
  std::string damaged = whole;
  damaged[whole.size() - 60] = static_cast<char>(damaged[whole.size() - 60] ^ 1);
  test::WriteText(path(), damaged);
  ExpectFrames(3, "summary");
  EXPECT_THAT(Note(), HasSubstr("the checksum of its summary is wrong: all of"));
  damaged = whole;
  damaged[whole.size() / 2] = static_cast<char>(damaged[whole.size() / 2] ^ 1);
  test::WriteText(path(), damaged);
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path(), "")->Read(1); }), HasSubstr("the checksum of a chunk is wrong"));
  EXPECT_EQ(OpenDataset(path(), "")->Read(2).frame_id, 2);
  test::WriteText(path(), damaged.substr(0, whole.size() - 20));
  EXPECT_EQ(OpenDataset(path(), "")->size(), 2);
  EXPECT_THAT(Note(), HasSubstr("damaged chunks or records skipped: 1 (the first: the checksum of a chunk"));
}

// As a power cut leaves it.
TEST_F(McapDataset, ZerosAfterTheLastRecordEndTheFile) {
  MakeMcapFile(path());
  const std::string whole = test::ReadText(path());
  const std::string data_end = test::McapRecordBytes(0x0f, std::string(4, '\0'));
  test::WriteText(path(), whole.substr(0, whole.rfind(data_end)) + std::string(5000, '\0'));
  ExpectFrames(3, "zeros");
  EXPECT_THAT(Note(),
              HasSubstr("its last 5000 bytes are not played because they belong to a record that is truncated or"));
}

TEST_F(McapDataset, MissingOrDamagedIndexIsReplacedByAScan) {
  MakeMcapFile(path(), {.indexed_chunks = 2});
  ExpectFrames(3, "chunk");
  EXPECT_THAT(Note(), HasSubstr("has an index of 2 chunks instead of 3: all of its"));
  testing::internal::CaptureStderr();
  OpenDatasetAndWarn(path(), "");
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("warning: " + path() + ": has an index of 2 chunks"));
  MakeMcapFile(path());
  const std::string whole = test::ReadText(path());
  // The last index of messages: kind, length, channel, and the length of one entry.
  const std::string index = test::RecordBytes().Add(uint8_t{7}).Add(uint64_t{22}).Add(uint16_t{0}).Add(16U).bytes();
  for (const size_t byte : {size_t{0}, size_t{9}, size_t{11}}) {
    std::string damaged = whole;
    ASSERT_NE(damaged.rfind(index), std::string::npos);
    damaged[damaged.rfind(index) + byte] ^= 16;
    test::WriteText(path(), damaged);
    ExpectFrames(3, "index");
    EXPECT_THAT(Note(), HasSubstr("its index cannot be used ("));
  }
}

TEST_F(McapDataset, OversizedChunksAreRefused) {
  std::string bomb = "\x89MCAP0\r\n", names;
  for (int i = 0; i < 10; ++i) bomb += test::McapChunk("zstd", "none", 128 << 20);
  test::WriteText(path(), bomb);
  EXPECT_THAT(Error(), HasSubstr("there are more bytes in its chunks than the file can contain"));
  for (uint16_t i = 0; i < 2000; ++i) {
    test::RecordBytes channel;
    channel.Add(i).Add(uint16_t{0}).Text(std::string(1000, 'a')).Text("cdr").Text("");
    names += test::McapRecordBytes(4, channel.bytes());
  }
  const std::string packed = test::CompressedChunk(names, "zstd");
  test::WriteText(path(), "\x89MCAP0\r\n" + test::McapChunk("zstd", packed, names.size()));
  EXPECT_THAT(Error(), HasSubstr("there are more messages and names than the file can contain"));
  test::WriteText(path(), "\x89MCAP0\r\n" + test::McapChunk("lz4", "four", 2000));
  EXPECT_THAT(Error(), HasSubstr("a chunk is damaged: lz4 reports 'another length'"));
}

TEST_F(McapDataset, OtherFileFormatsAreNamed) {
  test::WriteText(path(), "#ROSBAG V2.0\n and more");
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path(), "mcap"); }),
              HasSubstr("is not an MCAP file, because it begins with '#ROSBAG '"));
  test::WriteText(path(), "some text");
  EXPECT_THAT(Error(), HasSubstr(path() + ": is not an MCAP file, because it begins with 'some tex'"));
  test::WriteText(path(), "");
  EXPECT_THAT(Error(), HasSubstr(path() + ": is empty (0 bytes), not an MCAP file"));
}

}  // namespace
}  // namespace plslam
