// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/bag_file.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

using test::ErrorOf;
using test::MakeBagFile;
using testing::AllOf;
using testing::HasSubstr;

class BagDataset : public test::RecordingFileTest {
 protected:
  BagDataset() : RecordingFileTest("a.bag") {}
};

TEST_F(BagDataset, ChunksOfEachCompressionInAnyOrder) {
  for (const char* compression : {"", "lz4", "bz2"}) {
    for (const bool unsorted : {false, true}) {
      MakeBagFile(path(), {.compression = compression, .unsorted = unsorted});
      ExpectItsFrames(compression);
    }
  }
}

TEST_F(BagDataset, RigOfCameraInfo) {
  MakeBagFile(path());
  const RigCalibration rig = OpenDataset(path(), "")->rig();
  EXPECT_EQ(rig.name, "bag");
  EXPECT_EQ(rig.left.fx_px, 40.0);
  EXPECT_EQ(rig.left.cy_px, 16.0);
  EXPECT_EQ(rig.left.distortion, std::vector<double>({-0.28, 0.07, 0.0002, 1.8e-5, 0.0}));
  EXPECT_EQ(rig.baseline_m, 0.125);
  EXPECT_EQ(rig.rate_hz, 10.0);
}

TEST_F(BagDataset, TopicsAreFoundOrGiven) {
  MakeBagFile(path(), {.left = "/a/image", .right = "/b/image"});
  EXPECT_THAT(Error(), AllOf(HasSubstr(path() + ": no two image topics"), HasSubstr("are /a/image, /b/image")));
  EXPECT_EQ(OpenDataset(path() + "?left=/a/image&right=/b/image&truth=/ground_truth", "")->size(), 3);
  EXPECT_THAT(Error("?left=/a/image&right=/c"), HasSubstr("has no images on the topic right=/c"));
}

TEST_F(BagDataset, CutOffAndUnclosedFilesPlayIntactParts) {
  for (const char* compression : {"", "lz4", "bz2"}) {
    MakeBagFile(path(), {.compression = compression});
    std::string unclosed = test::ReadText(path());
    const size_t index_at = unclosed.find("index_pos=") + 10;
    test::WriteText(path(), unclosed.substr(0, unclosed.size() - 9));
    ExpectFrames(3, compression);
    EXPECT_THAT(Note(), HasSubstr("its index cannot be used (a record ends before its last field"));
    unclosed.replace(index_at, 8, 8, '\0');
    test::WriteText(path(), unclosed);
    ExpectFrames(3, compression);
    EXPECT_THAT(Note(), AllOf(HasSubstr("has no index because it was not closed: all of its 0.0 MB were read"),
                              HasSubstr("`rosbag reindex` writes an index")));
  }
  MakeBagFile(path());
  const std::string whole = test::ReadText(path());
  test::WriteText(path(), whole.substr(0, whole.size() / 2));
  ExpectFrames(1, "half");
  EXPECT_THAT(Note(), AllOf(HasSubstr("its index would begin at byte"), HasSubstr("bytes are missing)")));
}

// The chunk that was being written when the recorder was killed has a length of 0 in its head.
TEST_F(BagDataset, UnfinishedLastChunkAfterAKill) {
  MakeBagFile(path());
  std::string killed = test::ReadText(path());
  const size_t last = killed.rfind("compression=none");
  const size_t size_at = killed.find("size=", last) + 5;
  const size_t data_at = killed.find("op=\5", last) + 4;
  ASSERT_LT(size_at, killed.size());
  const size_t n = static_cast<uint8_t>(killed[size_at]) + 256U * static_cast<uint8_t>(killed[size_at + 1]);
  killed.resize(data_at + 4 + n);
  for (const size_t at : {size_at, data_at, killed.find("index_pos=") + 10}) killed.replace(at, 4, 4, '\0');
  test::WriteText(path(), killed);
  ExpectFrames(3, "all");
  test::WriteText(path(), killed.substr(0, killed.size() - 1));
  const auto dataset = OpenDataset(path(), "");
  EXPECT_EQ(dataset->size(), 3) << "the pose behind the images is cut off";
  EXPECT_TRUE(dataset->GroundTruth(1));
  EXPECT_FALSE(dataset->GroundTruth(2));
}

TEST_F(BagDataset, ZerosAfterTheLastRecordEndTheFile) {
  MakeBagFile(path());
  std::string unclosed = test::ReadText(path());
  unclosed.replace(unclosed.find("index_pos=") + 10, 8, 8, '\0');
  test::WriteText(path(), unclosed + std::string(5000, '\0'));
  ExpectFrames(3, "zeros");
  EXPECT_THAT(Note(),
              HasSubstr("its last 5000 bytes are not played because they belong to a record that is truncated or"));
}

TEST_F(BagDataset, DamagedIndexOfMessagesIsReplacedByAScan) {
  MakeBagFile(path());
  std::string damaged = test::ReadText(path());
  damaged[damaged.find("conn=", damaged.find("ver=")) + 3] = 'm';
  test::WriteText(path(), damaged);
  ExpectFrames(3, "index");
  EXPECT_THAT(Note(), HasSubstr("its index cannot be used (a record has no field 'conn'"));
}

TEST_F(BagDataset, OtherFileFormatsAreNamed) {
  test::WriteText(path(), "#ROSBAG V1.2\n and more");
  EXPECT_THAT(Error(),
              HasSubstr("begins with '#ROSBAG V1.2', not with '#ROSBAG V2.0': convert it to 2.0 with `rosbag fix`"));
  test::WriteText(path(), "");
  EXPECT_THAT(Error(), HasSubstr(path() + ": is empty (0 bytes), not a ROS 1 bag"));
  test::WriteText(path(), "some text");
  EXPECT_THAT(Error(), HasSubstr(path() + ": is not a ROS 1 bag, because it begins with 'some text': give a file"));
  test::WriteText(path(), "#ROSBAG V2.0\n");
  EXPECT_THAT(Error(), HasSubstr("a record ends before its last field"));
}

TEST_F(BagDataset, DamagedChunksAreReported) {
  MakeBagFile(path(), {.compression = "bz2"});
  std::string damaged = test::ReadText(path());
  damaged[damaged.find("BZh") + 200] ^= 1;
  test::WriteText(path(), damaged);
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path() + "?camera=/nowhere.yaml", ""); }), HasSubstr("nowhere.yaml"));
  EXPECT_THAT(Error(), HasSubstr("a chunk is damaged: bz2 reports 'error -"));
}

}  // namespace
}  // namespace plslam
