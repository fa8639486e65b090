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

TEST_F(BagDataset, CutOffUnclosedAndForeignFilesAreTold) {
  MakeBagFile(path());
  const std::string whole = test::ReadText(path());
  test::WriteText(path(), whole.substr(0, whole.size() / 2));
  EXPECT_THAT(Error(), AllOf(HasSubstr(path() + ": its index would begin at byte"), HasSubstr("`rosbag reindex`")));
  test::WriteText(path(), whole.substr(0, whole.size() - 9));
  EXPECT_THAT(Error(), HasSubstr("a record ends before its last field"));
  std::string unclosed = whole;
  unclosed.replace(whole.find("index_pos=") + 10, 8, 8, '\0');
  test::WriteText(path(), unclosed);
  EXPECT_THAT(Error(), HasSubstr("has no index, since it was not closed: `rosbag reindex` writes one"));
  test::WriteText(path(), "#ROSBAG V1.2\n and more");
  EXPECT_THAT(Error(), HasSubstr("begins with '#ROSBAG V1.2', not with '#ROSBAG V2.0': `rosbag fix`"));
  test::WriteText(path(), "");
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path(), "bag"); }), HasSubstr(path() + ": is no bag of ROS 1"));
  test::WriteText(path(), "#ROSBAG V2.0\n");
  EXPECT_THAT(Error(), HasSubstr("a record ends before its last field"));
}

TEST_F(BagDataset, DamagedChunksAreToldWithTheirFrame) {
  MakeBagFile(path(), {.compression = "bz2"});
  std::string damaged = test::ReadText(path());
  damaged[damaged.find("BZh") + 200] ^= 1;
  test::WriteText(path(), damaged);
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path() + "?camera=/nowhere.yaml", ""); }), HasSubstr("nowhere.yaml"));
  EXPECT_THAT(Error(), HasSubstr("a chunk is damaged: bz2 says 'error -4'"));
}

}  // namespace
}  // namespace plslam
