// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/tum_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/datasets/image_list.h"
#include "tests/support/data_folder.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

class TumDataset : public testing::Test {
 protected:
  TumDataset() { test::MakeTumFolder(folder_); }
  std::string OpenError() const {
    return ErrorOf([this] { OpenTumDataset(folder_.string()); });
  }
  std::string At(const std::string& name) const { return (folder_ / name).string(); }

  test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "rgbd_dataset_fr1_tiny";
};

TEST_F(TumDataset, HandMadeFolder) {
  ASSERT_TRUE(LooksLikeTum(folder_.string()));
  const auto dataset = OpenTumDataset(folder_.string());
  ASSERT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->t_ns(0), 1305031102175304000);
  const RigCalibration& rig = dataset->rig();
  EXPECT_EQ(rig.kind, RigCalibration::Kind::kRgbd);
  EXPECT_EQ(rig.name, "freiburg1");
  EXPECT_EQ(rig.left.fx_px, 517.3);
  EXPECT_EQ(rig.left.distortion.size(), 5);
  EXPECT_EQ(rig.depth_units_per_m, 5000.0);
  EXPECT_NEAR(rig.left.fx_px * rig.baseline_m, 40.0, 2.0);
  EXPECT_DOUBLE_EQ(rig.right.T_b_cam.translation().x(), rig.baseline_m);
  const StereoImages images = dataset->Read(2);
  // 0.114 * 10 + 0.587 * 100 + 0.299 * 200 of the BGR image (10, 100, 200).
  EXPECT_EQ(images.left.at<uint8_t>(100, 100), 120);
  EXPECT_EQ(images.right.type(), CV_16UC1);
  EXPECT_EQ(images.right.at<uint16_t>(479, 639), 5200);
  EXPECT_DOUBLE_EQ(dataset->GroundTruth(2)->translation().x(), 2.0);
}

TEST_F(TumDataset, NameOfALinkOrItsTargetGivesTheCamera) {
  const fs::path plain = temporary_.path() / "data", named = temporary_.path() / "fr2_desk";
  fs::create_directory_symlink(folder_, plain);
  EXPECT_EQ(OpenTumDataset(plain.string())->rig().name, "freiburg1");
  fs::remove(plain);
  fs::rename(folder_, plain);
  fs::create_directory_symlink(plain, named);
  EXPECT_EQ(OpenTumDataset(named.string() + "/")->rig().name, "freiburg2");
}

TEST_F(TumDataset, AssociationsFileInEitherOrder) {
  test::WriteText(folder_ / "associations.txt",
                  "1305031102.175304 rgb/1305031102.175304.png 1305031102.180000 depth/0.png\r\n"
                  "1305031102.480000 depth/2.png 1305031102.375304 rgb/1305031102.375304.png\n");
  const auto dataset = OpenTumDataset(folder_.string());
  ASSERT_EQ(dataset->size(), 2);
  EXPECT_EQ(dataset->t_ns(1), 1305031102375304000);
  EXPECT_EQ(dataset->Read(1).right.at<uint16_t>(0, 0), 5200);
  test::WriteText(folder_ / "associations.txt", "1305031102.175304 rgb/1305031102.175304.png 1305031102.18\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("associations.txt") + ":1: 3 columns instead of 4"));
  test::WriteText(folder_ / "associations.txt", "# nothing\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("associations.txt") + ": lists no pairs"));
}

TEST_F(TumDataset, ImagesWithoutPartnerWithin20MsAreReported) {
  test::ReplaceText(folder_ / "depth.txt", "1305031102.280000", "1305031102.295400");
  const auto dataset = OpenTumDataset(folder_.string());
  EXPECT_EQ(dataset->size(), 2);
  EXPECT_THAT(dataset->Notes().warnings, ElementsAre(HasSubstr("1 of 3 colour images has no partner within 20 ms"),
                                                     HasSubstr("1 of 3 depth maps")));
}

TEST_F(TumDataset, CameraByNameOrFile) {
  const fs::path other = temporary_.path() / "office";
  fs::rename(folder_, other);
  EXPECT_THAT(ErrorOf([&] { OpenTumDataset(other.string()); }),
              AllOf(HasSubstr(other.string()), HasSubstr("no camera.yaml"), HasSubstr("freiburg1")));
  test::WriteText(other / "camera.yaml",
                  "kind: rgbd\ndepth_units_per_m: 1000\nbaseline_m: 0.1\n"
                  "left: {focal_length_px: [500, 500], principal_point_px: [320, 240]}\n");
  const auto dataset = OpenTumDataset(other.string() + "/.");
  EXPECT_EQ(dataset->rig().depth_units_per_m, 1000.0);
  EXPECT_EQ(dataset->rig().baseline_m, 0.1);
  EXPECT_EQ(dataset->rig().left.model, "pinhole");
  test::ReplaceText(other / "camera.yaml", "kind: rgbd\ndepth_units_per_m: 1000\n", "kind: stereo\n");
  EXPECT_THAT(ErrorOf([&] { OpenTumDataset(other.string()); }), HasSubstr("kind must be rgbd"));
}

TEST_F(TumDataset, Freiburg2And3) {
  const fs::path two = temporary_.path() / "rgbd_dataset_freiburg2_desk";
  fs::rename(folder_, two);
  EXPECT_EQ(OpenTumDataset(two.string() + "/")->rig().left.fx_px, 520.9);
  const fs::path three = temporary_.path() / "fr3_office";
  fs::rename(two, three);
  EXPECT_EQ(OpenTumDataset(three.string())->rig().left.fy_px, 539.2);
}

TEST_F(TumDataset, DepthMapOf8BitsIsRefused) {
  fs::copy_file(folder_ / "rgb" / "1305031102.175304.png", folder_ / "depth" / "0.png",
                fs::copy_options::overwrite_existing);
  const auto dataset = OpenTumDataset(folder_.string());
  EXPECT_THAT(ErrorOf([&] { dataset->Read(0); }), AllOf(HasSubstr(At("depth/0.png")), HasSubstr("16 bits")));
}

TEST_F(TumDataset, BadListsAreNamedWithTheirLine) {
  const std::string good = test::ReadText(folder_ / "rgb.txt");
  test::WriteText(folder_ / "rgb.txt", "# c\n5.0 rgb/a.png\n4.9 rgb/b.png\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("rgb.txt") + ":3: "), HasSubstr("not after")));
  test::WriteText(folder_ / "rgb.txt", "5.0 /etc/a.png\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("rgb.txt") + ":1: "), HasSubstr("leaves the folder")));
  test::WriteText(folder_ / "rgb.txt", "1305031102175304000 rgb/a.png\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("rgb.txt") + ":1: "), HasSubstr("too large")));
  test::WriteText(folder_ / "rgb.txt", "5.0 rgb/a.png\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("depth.txt")), HasSubstr("within 20 ms")));
  test::WriteText(folder_ / "rgb.txt", good);
  test::ReplaceText(folder_ / "groundtruth.txt", "0 0 0 1\n", "0 0 0 1 7\n");
  EXPECT_THAT(OpenTumDataset(folder_.string())->Notes().warnings,
              testing::Contains(AllOf(HasSubstr(At("groundtruth.txt") + ":2: "), HasSubstr("skipped"))));
}

TEST_F(TumDataset, RealSequence) {
  PLSLAM_REQUIRE_DATA(real, "tum_fr1_xyz");
  const auto dataset = OpenTumDataset(real.string());
  ASSERT_EQ(dataset->size(), 60);
  int n_truth = 0;
  for (int i = 0; i < dataset->size(); ++i) n_truth += dataset->GroundTruth(i).has_value() ? 1 : 0;
  EXPECT_EQ(n_truth, 60);
  EXPECT_NEAR(dataset->rig().rate_hz, 10.0, 0.1);
  const StereoImages images = dataset->Read(59);
  EXPECT_EQ(images.left.size(), cv::Size(640, 480));
  EXPECT_EQ(images.right.type(), CV_16UC1);
}

TEST(AssociateTimes, NearestPairsAreServedFirst) {
  // 100 is nearer to 101 than 104 is, and 104 then gets the remaining one in reach.
  EXPECT_THAT(AssociateTimes({100, 104, 300}, {101, 109, 200}, 10), ElementsAre(Pair(0, 0), Pair(1, 1)));
  EXPECT_THAT(AssociateTimes({}, {1}, 10), ElementsAre());
  EXPECT_THAT(AssociateTimes({5}, {}, 10), ElementsAre());
  EXPECT_THAT(AssociateTimes({5}, {15}, 10), ElementsAre(Pair(0, 0)));
  EXPECT_THAT(AssociateTimes({5}, {16}, 10), ElementsAre());
}

}  // namespace
}  // namespace plslam
