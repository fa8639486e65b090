// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/kitti_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/data_folder.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

class KittiDataset : public testing::Test {
 protected:
  KittiDataset() { test::MakeKittiFolder(folder_); }
  std::string OpenError() const {
    return ErrorOf([this] { OpenKittiDataset(folder_.string()); });
  }
  std::string ReadError(int index) const {
    const auto dataset = OpenKittiDataset(folder_.string());
    return ErrorOf([&] { dataset->Read(index); });
  }
  // Returns the path of a file as it appears in a sentence.
  std::string At(const std::string& name) const { return (folder_ / name).string(); }

  test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "sequence";
};

TEST_F(KittiDataset, HandMadeFolder) {
  ASSERT_TRUE(LooksLikeKitti(folder_.string()));
  const auto dataset = OpenKittiDataset(folder_.string());
  ASSERT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->t_ns(1), 100'000'000);
  EXPECT_EQ(dataset->rig().left.fx_px, 40.0);
  EXPECT_EQ(dataset->rig().left.width_px, test::kTinyWidth_px);
  EXPECT_DOUBLE_EQ(dataset->rig().baseline_m, 0.5);
  EXPECT_DOUBLE_EQ(dataset->rig().right.T_b_cam.translation().x(), 0.5);
  EXPECT_DOUBLE_EQ(dataset->rig().rate_hz, 10.0);
  const StereoImages images = dataset->Read(2);
  EXPECT_EQ(images.frame_id, 2);
  EXPECT_EQ(images.t_ns, 200'000'000);
  EXPECT_EQ(images.left.at<uint8_t>(3, 4), test::TinyPixel(2, 0, 4, 3));
  EXPECT_EQ(images.right.at<uint8_t>(3, 4), test::TinyPixel(2, 1, 4, 3));
  EXPECT_DOUBLE_EQ(dataset->GroundTruth(2)->translation().z(), 1.5);
}

TEST_F(KittiDataset, ColourPairHasItsOwnPoseInTheBody) {
  fs::rename(folder_ / "image_0", folder_ / "image_2");
  fs::rename(folder_ / "image_1", folder_ / "image_3");
  test::WriteText(folder_ / "calib.txt",
                  "P2: 40 0 24 4 0 40 16 8 0 0 1 0.25\nP3: 40 0 24 -16 0 40 16 8 0 0 1 0.25\n");
  const auto dataset = OpenKittiDataset(folder_.string());
  // K^-1 (4, 8, 0.25) = ((4 - 6) / 40, (8 - 4) / 40, 0.25), and the camera is at its negative.
  EXPECT_TRUE(dataset->rig().left.T_b_cam.translation().isApprox(Eigen::Vector3d(0.05, -0.1, -0.25), 1e-12));
  EXPECT_DOUBLE_EQ(dataset->rig().baseline_m, 0.5);
  // Poses are those of the grey camera.
  EXPECT_TRUE(dataset->GroundTruth(1)->translation().isApprox(Eigen::Vector3d(0.05, -0.1, 0.25), 1e-12));
}

TEST_F(KittiDataset, OfficialLayoutHasPosesBesideSequences) {
  const fs::path official = temporary_.path() / "sequences" / "03";
  fs::create_directories(official.parent_path());
  fs::rename(folder_, official);
  fs::create_directories(temporary_.path() / "poses");
  fs::rename(official / "poses.txt", temporary_.path() / "poses" / "03.txt");
  const auto dataset = OpenKittiDataset(official.string() + "/");
  ASSERT_TRUE(dataset->GroundTruth(1));
  EXPECT_DOUBLE_EQ(dataset->GroundTruth(1)->translation().z(), 0.5);
}

TEST_F(KittiDataset, LinkedSequencesKeepTheirPoses) {
  const fs::path link = temporary_.path() / "sequences" / "03", poses = temporary_.path() / "poses";
  fs::create_directories(link.parent_path());
  fs::create_directory_symlink(folder_, link);
  fs::create_directories(poses);
  fs::rename(folder_ / "poses.txt", poses / "03.txt");
  EXPECT_TRUE(OpenKittiDataset(link.string() + "/")->GroundTruth(1)) << "a link within the benchmark's layout";
  const fs::path short_name = temporary_.path() / "short", official = temporary_.path() / "sequences" / "04";
  fs::rename(folder_, official);
  fs::rename(poses / "03.txt", poses / "04.txt");
  fs::create_directory_symlink(official, short_name);
  EXPECT_TRUE(OpenKittiDataset(short_name.string())->GroundTruth(1)) << "a link to it";
}

TEST_F(KittiDataset, WithoutPosesThereIsNoGroundTruth) {
  fs::remove(folder_ / "poses.txt");
  EXPECT_FALSE(OpenKittiDataset(folder_.string())->GroundTruth(0));
}

TEST_F(KittiDataset, CarriageReturnsAndTrailingBlanksAreAccepted) {
  test::WriteText(folder_ / "times.txt", "0.0 \r\n0.1\t\r\n0.2\r\n\r\n");
  test::ReplaceText(folder_ / "calib.txt", "1 0\n", "1 0  \r\n");
  EXPECT_EQ(OpenKittiDataset(folder_.string())->size(), 3);
}

TEST_F(KittiDataset, MissingFilesAreNamed) {
  fs::remove(folder_ / "times.txt");
  EXPECT_THAT(OpenError(), HasSubstr(At("times.txt")));
  fs::remove(folder_ / "calib.txt");
  EXPECT_THAT(OpenError(), HasSubstr(At("calib.txt")));
  EXPECT_FALSE(LooksLikeKitti(folder_.string()));
  fs::remove_all(folder_ / "image_1");
  EXPECT_THAT(OpenError(), HasSubstr("neither image_0 and image_1"));
}

TEST_F(KittiDataset, BadCalibrationIsNamedWithItsLine) {
  test::WriteText(folder_ / "calib.txt", "P0: 0 0 24 0 0 40 16 0 0 0 1 0\nP1: 40 0 24 -20 0 40 16 0 0 0 1 0\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("calib.txt") + ":1: P0:"), HasSubstr("f = 0")));
  test::WriteText(folder_ / "calib.txt", "P0: 40 0 24 0 0 40 16 0 0 0 1 0\nP1: 40 0 24 nan 0 40 16 0 0 0 1 0\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("calib.txt") + ":2: "), HasSubstr("'nan'")));
  test::WriteText(folder_ / "calib.txt", "P0: 40 0 24 0 0 40 16 0 0 0 1\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("calib.txt") + ":1: "), HasSubstr("12 columns instead of 13")));
  test::WriteText(folder_ / "calib.txt", "P0: 40 0 24 0 0 40 16 0 0 0 1 0\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("calib.txt")), HasSubstr("no line P1:")));
  test::WriteText(folder_ / "calib.txt", "P0: 40 0 24 0 0 40 16 0 0 0 1 0\nP1: 40 0 24 20 0 40 16 0 0 0 1 0\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("calib.txt")), HasSubstr("to the right of the left one")));
  test::WriteText(folder_ / "calib.txt", "P0: 40 0 24 0 0 40 16 0 0 0 1 0\nP1: 40 0 24 0 0 40 16 0 0 0 1 0\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("calib.txt")), HasSubstr("baseline 0 m")));
  test::WriteText(folder_ / "calib.txt",
                  "P0: 1e300 0 24 0 0 40 16 0 0 0 1 0\nP1: 1e300 0 24 -20 0 40 16 0 0 0 1 0\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("calib.txt")), HasSubstr("focal length fx = 1e+300")));
}

TEST_F(KittiDataset, TimesThatGoBackOrRepeatAreNamedWithTheirLine) {
  test::WriteText(folder_ / "times.txt", "0.0\n0.2\n0.1\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("times.txt") + ":3: time 100000000 ns is not after the 200000000 ns"));
  test::WriteText(folder_ / "times.txt", "0.0\n0.1\n0.1\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("times.txt") + ":3: "));
  test::WriteText(folder_ / "times.txt", "0.0\nsoon\n0.1\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("times.txt") + ":2: "), HasSubstr("'soon'")));
  test::WriteText(folder_ / "times.txt", "-1\n0.1\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("times.txt") + ":1: "), HasSubstr("negative")));
  test::WriteText(folder_ / "times.txt", "0 1\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("times.txt") + ":1: 2 columns instead of 1"));
  test::WriteText(folder_ / "times.txt", "1e30\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("times.txt") + ":1: "), HasSubstr("too large")));
  test::WriteText(folder_ / "times.txt", "\n\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("times.txt") + ": has no times"));
}

TEST_F(KittiDataset, BadPosesAreNotedWithTheirLine) {
  const auto note = [&] {
    const auto dataset = OpenKittiDataset(folder_.string());
    EXPECT_EQ(dataset->size(), 3);
    return dataset->Notes().warnings.empty() ? "" : dataset->Notes().warnings.back();
  };
  test::ReplaceText(folder_ / "poses.txt", "0.5", "nan");
  EXPECT_THAT(note(), AllOf(HasSubstr(At("poses.txt") + ":2: "), HasSubstr("'nan'"), HasSubstr("1 of 3 rows is")));
  const auto dataset = OpenKittiDataset(folder_.string());
  EXPECT_TRUE(dataset->GroundTruth(0));
  EXPECT_FALSE(dataset->GroundTruth(1));
  EXPECT_TRUE(dataset->GroundTruth(2));
  test::WriteText(folder_ / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THAT(note(), HasSubstr(At("poses.txt") + ": has 1 poses for 3 frames"));
}

TEST_F(KittiDataset, EmptyImageFolder) {
  fs::remove_all(folder_ / "image_0");
  fs::create_directories(folder_ / "image_0");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("image_0")), HasSubstr("none of the 3 images")));
}

TEST_F(KittiDataset, MissingAndTruncatedImagesFailAtTheirFrameOnly) {
  fs::remove(folder_ / "image_1" / "000001.png");
  fs::resize_file(folder_ / "image_0" / "000002.png", 120);
  EXPECT_THAT(ReadError(1), AllOf(HasSubstr(At("image_1/000001.png")), EndsWith("the image is missing")));
  EXPECT_THAT(ReadError(2), AllOf(HasSubstr(At("image_0/000002.png")), HasSubstr("truncated after 120 bytes")));
  EXPECT_EQ(OpenKittiDataset(folder_.string())->Read(0).left.cols, test::kTinyWidth_px);
}

TEST_F(KittiDataset, DamagedFirstFrameLeavesTheOthersReadable) {
  test::WriteText(folder_ / "image_0" / "000000.png", "");
  EXPECT_THAT(ReadError(0), AllOf(HasSubstr(At("image_0/000000.png")), HasSubstr("empty")));
  EXPECT_EQ(OpenKittiDataset(folder_.string())->Read(1).right.rows, test::kTinyHeight_px);
}

TEST_F(KittiDataset, RealSequence03) {
  PLSLAM_REQUIRE_DATA(real, "kitti_03");
  const auto dataset = OpenKittiDataset(real.string());
  ASSERT_EQ(dataset->size(), 75);
  EXPECT_EQ(dataset->rig().left.width_px, 1242);
  EXPECT_EQ(dataset->rig().left.height_px, 375);
  EXPECT_NEAR(dataset->rig().baseline_m, 387.5744 / 721.5377, 1e-9);
  EXPECT_EQ(dataset->t_ns(1), 103'391'400);
  EXPECT_NEAR(dataset->GroundTruth(1)->translation().z(), 0.9617130, 1e-9);
  int n_truth = 0;
  for (int i = 0; i < dataset->size(); ++i) n_truth += dataset->GroundTruth(i).has_value() ? 1 : 0;
  EXPECT_EQ(n_truth, 75);
  EXPECT_EQ(dataset->Read(74).right.size(), cv::Size(1242, 375));
}

TEST(KittiLayout, OtherRealSequences) {
  struct Row {
    const char* name;
    int n_frames;
    bool has_truth;
    int width_px;
    int height_px;
    double baseline_m;
  };
  for (const Row& row :
       {Row{"sand_rand", 163, false, 512, 285, 0.0696}, Row{"tsukuba_lamps_a", 55, false, 640, 480, 0.1},
        Row{"tartanair2_10", 10, true, 640, 640, 0.25}}) {
    PLSLAM_REQUIRE_DATA(real, row.name);
    const auto dataset = OpenKittiDataset(real.string());
    EXPECT_EQ(dataset->size(), row.n_frames) << row.name;
    EXPECT_EQ(dataset->GroundTruth(0).has_value(), row.has_truth) << row.name;
    EXPECT_EQ(dataset->Read(row.n_frames - 1).left.size(), cv::Size(row.width_px, row.height_px)) << row.name;
    EXPECT_NEAR(dataset->rig().baseline_m, row.baseline_m, 1e-9) << row.name;
  }
}

}  // namespace
}  // namespace plslam
