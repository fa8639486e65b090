// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

using test::ErrorOf;
using testing::AllOf;
using testing::HasSubstr;

TEST(OpenDataset, EveryFormatIsFoundByContentAndByName) {
  const test::TemporaryFolder folder;
  test::MakeKittiFolder(folder.path() / "kitti");
  test::MakeEurocFolder(folder.path() / "euroc");
  test::MakeTumFolder(folder.path() / "tum_fr1");
  test::MakeImagesFolder(folder.path() / "images");
  for (const auto& [name, kind] :
       {std::pair{"kitti", "kitti"}, {"euroc", "euroc"}, {"tum_fr1", "tum"}, {"images", "images"}}) {
    const std::string location = (folder.path() / name).string();
    EXPECT_EQ(OpenDataset(location, "")->size(), 3) << name;
    EXPECT_EQ(OpenDataset(location, kind)->size(), 3) << name;
  }
}

TEST(OpenDataset, SyntheticWorldByName) {
  const auto world = OpenDataset("synthetic:room", "");
  EXPECT_GT(world->size(), 0);
  EXPECT_TRUE(world->GroundTruth(0));
}

TEST(OpenDataset, ErrorsNameTheKnownFormats) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(
      ErrorOf([&] { OpenDataset(folder.path().string(), ""); }),
      AllOf(HasSubstr(folder.path().string()), HasSubstr("kitti: calib.txt"), HasSubstr("images: camera.yaml")));
  EXPECT_THAT(ErrorOf([] { OpenDataset("/nowhere/at/all", ""); }),
              HasSubstr("/nowhere/at/all: the dataset does not exist"));
  EXPECT_THAT(ErrorOf([&] { OpenDataset(folder.path().string(), "rosbag"); }),
              AllOf(HasSubstr("'rosbag'"), HasSubstr("kitti, euroc, tum, images")));
  EXPECT_THAT(ErrorOf([] { OpenDataset("/nowhere/at/all", "euroc"); }), HasSubstr("/nowhere/at/all"));
}

TEST(OpenDataset, VideosAreSentToTheCameraProcess) {
  const test::TemporaryFolder folder;
  const std::string video = (folder.path() / "v.mp4").string();
  test::WriteText(video, "????ftypisom");
  EXPECT_THAT(ErrorOf([&] { OpenDataset(video, ""); }), AllOf(HasSubstr(video + ": is a video: the process camera"),
                                                              HasSubstr("files: [left.mp4, right.mp4]")));
}

TEST(OpenDataset, YamlThatIsNoRigFileIsExplained) {
  const test::TemporaryFolder folder;
  const std::string rig = (folder.path() / "rig.yaml").string();
  test::WriteText(rig, "devices: [/dev/video0, /dev/video2]\n");
  EXPECT_THAT(ErrorOf([&] { OpenDataset(rig, ""); }), HasSubstr(rig + ": is a YAML file without `source:`"));
}

TEST(OpenDataset, TopicsBelongToTheNameOfARecording) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "a.mcap").string();
  test::WriteText(file, "");
  EXPECT_EQ(WithTopics(file, "", {"/a", "/b"}), file + "?left=/a&right=/b");
  EXPECT_EQ(WithTopics(file + "?camera=c.yaml", "", {"/a", "/b"}), file + "?camera=c.yaml&left=/a&right=/b");
  EXPECT_EQ(WithTopics("/nowhere", "", {}), "/nowhere");
  EXPECT_THAT(ErrorOf([] {
                WithTopics("synthetic:room", "", {"/a", "/b"});
              }),
              HasSubstr("synthetic:room: --topics is only for ROS recordings"));
  EXPECT_THAT(ErrorOf([] { WithTopics("/nowhere", "", {"/a", "/b"}); }), HasSubstr("the dataset does not exist"));
  EXPECT_THAT(ErrorOf([&] { WithTopics(file, "", {"/a&truth=/c", "/b"}); }), HasSubstr("is not a ROS topic"));
  EXPECT_THAT(ErrorOf([] { WithTopics(std::string(5000, 'a'), "", {"/a", "/b"}); }), HasSubstr("File name too long"));
}

TEST(OpenDataset, HelpNamesEveryFormat) {
  for (const DatasetKind& kind : DatasetKinds()) {
    EXPECT_THAT(DatasetHelp(), HasSubstr(kind.what));
    EXPECT_THAT(DatasetKindHelp(), HasSubstr(kind.name));
  }
}

}  // namespace

namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kFiveFrames = "synthetic:room?size=64x48&frames=5&noise=0";

bool Same(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0.0; }

TEST(ShiftedDataset, LeftImagesGetRightImagesOfOtherFrames) {
  const auto original = OpenDataset(kFiveFrames, "");
  for (const int offset : {-2, -1, 0, 1, 3}) {
    const auto shifted = ShiftRightImages(OpenDataset(kFiveFrames, ""), offset);
    ASSERT_EQ(shifted->size(), 5 - std::abs(offset)) << offset;
    for (int i = 0; i < shifted->size(); ++i) {
      const int left = i + std::max(-offset, 0);
      const StereoImages images = shifted->Read(i);
      EXPECT_TRUE(Same(images.left, original->Read(left).left)) << offset;
      EXPECT_TRUE(Same(images.right, original->Read(left + offset).right)) << offset;
      EXPECT_EQ(images.frame_id, i);
      EXPECT_EQ(shifted->t_ns(i), original->t_ns(left));
      EXPECT_EQ(shifted->GroundTruth(i)->matrix(), original->GroundTruth(left)->matrix());
    }
  }
}

TEST(ShiftedDataset, NoPairsLeftIsAnError) {
  EXPECT_THAT(test::ErrorOf([] { ShiftRightImages(OpenDataset(kFiveFrames, ""), -5); }),
              AllOf(HasSubstr("player.right_offset_frames=-5"), HasSubstr("none of its 5 frames")));
}

}  // namespace
}  // namespace plslam
