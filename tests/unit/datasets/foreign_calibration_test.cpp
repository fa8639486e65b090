// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/calibrations/foreign_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/datasets/camera_file.h"
#include "core/datasets/images_dataset.h"
#include "core/geometry/distortion.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"
#include "tests/unit/datasets/foreign_files.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using testing::AllOf;
using testing::HasSubstr;

constexpr ImageSize kSize{672, 376};

class ForeignCalibrationTest : public testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    test::WriteText(folder_ / name, text);
    return (folder_ / name).string();
  }
  std::vector<std::string> WriteAll(const test::ForeignRig& rig) const {
    std::vector<std::string> paths;
    for (const test::ForeignFile& file : rig.files) paths.push_back(Write(file.name, file.text));
    return paths;
  }
  static const test::ForeignRig& RigCalled(const std::string& name) {
    for (const test::ForeignRig& rig : test::ForeignRigs()) {
      if (rig.files.front().name == name) return rig;
    }
    throw std::runtime_error("no file " + name);
  }
  static std::string Replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
  }

  test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
};

void ExpectLens(const CameraCalibration& camera, const std::vector<double>& intrinsics,
                const std::vector<double>& distortion, const std::string& what) {
  EXPECT_EQ(camera.width_px, kSize.width_px) << what;
  EXPECT_EQ(camera.height_px, kSize.height_px) << what;
  EXPECT_DOUBLE_EQ(camera.fx_px, intrinsics[0]) << what;
  EXPECT_DOUBLE_EQ(camera.fy_px, intrinsics[1]) << what;
  EXPECT_DOUBLE_EQ(camera.cx_px, intrinsics[2]) << what;
  EXPECT_DOUBLE_EQ(camera.cy_px, intrinsics[3]) << what;
  CameraCalibration expected;
  expected.model = "radtan";
  expected.distortion = distortion;
  for (const Eigen::Vector2d& xy : {Eigen::Vector2d(0.5, -0.3), Eigen::Vector2d(-0.1, 0.4)}) {
    const auto seen = Distortion(camera).Distort(xy), wanted = Distortion(expected).Distort(xy);
    ASSERT_TRUE(seen && wanted) << what;
    EXPECT_LT((*seen - *wanted).norm(), 1e-12) << what;
  }
}

void ExpectTheRig(const RigCalibration& rig, const std::string& what) {
  ExpectLens(rig.left, {458.5, 457.25, 335.5, 188.75}, {-0.28, 0.07, 0.0002, -0.0001}, what);
  ExpectLens(rig.right, {459.5, 458.25, 337.25, 186.5}, {-0.27, 0.06, -0.0003, 0.0004}, what);
  const SE3 expected(Eigen::Quaterniond(0.99712, 0.0, 0.07584, 0.0), Eigen::Vector3d(0.12, 0.035, 0.0));
  const SE3 T_l_r = rig.left.T_b_cam.Inverse() * rig.right.T_b_cam;
  EXPECT_LT((T_l_r.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-12) << what << "\n" << T_l_r.matrix();
  EXPECT_NEAR(rig.baseline_m, 0.125, 1e-12) << what;
}

TEST_F(ForeignCalibrationTest, OneRigReadsAlikeInEveryFormat) {
  for (const test::ForeignRig& rig : test::ForeignRigs()) {
    const std::vector<std::string> paths = WriteAll(rig);
    EXPECT_EQ(ForeignFormat(paths.front()), rig.format);
    const ForeignCalibration read = ReadForeignCalibration(paths, kSize);
    EXPECT_EQ(read.format, rig.format);
    EXPECT_FALSE(read.direction.empty());
    ExpectTheRig(read.rig, rig.files.front().name);
  }
}

TEST_F(ForeignCalibrationTest, AndSurvivesTheWayThroughOurFile) {
  for (const test::ForeignRig& rig : test::ForeignRigs()) {
    const std::string own = Write("own.yaml", CameraFileText(ReadForeignCalibration(WriteAll(rig), kSize).rig));
    EXPECT_EQ(ForeignFormat(own), "");
    ExpectTheRig(ReadCameraFile(own, {0, 0}), rig.files.front().name);
  }
}

TEST_F(ForeignCalibrationTest, IsTakenInPlaceOfOurFile) {
  for (const test::ForeignRig& rig : test::ForeignRigs()) {
    const fs::path dataset = folder_ / ("with " + rig.files.front().name);
    fs::create_directories(dataset);
    for (const test::ForeignFile& file : rig.files) test::WriteText(dataset / file.name, file.text);
    ASSERT_TRUE(LooksLikeImages(dataset.string())) << dataset;
    ExpectTheRig(ReadCalibration(CalibrationOf(dataset.string()), kSize), dataset.string());
  }
}

TEST_F(ForeignCalibrationTest, OurFileMayNameOthers) {
  WriteAll(RigCalled("left.yaml"));
  const std::string own = Write("camera.yaml", "from: [left.yaml, right.yaml]\nname: pair\nrate_hz: 15\n");
  const RigCalibration rig = ReadCameraFile(own, kSize);
  ExpectTheRig(rig, own);
  EXPECT_EQ(rig.name, "pair");
  EXPECT_EQ(rig.rate_hz, 15.0);
  Write("camera.yaml", "from: ../left.yaml\n");
  EXPECT_THAT(ErrorOf([&] { ReadCameraFile(own, kSize); }), HasSubstr("leaves the folder"));
}

TEST_F(ForeignCalibrationTest, AFolderOfImagesPlays) {
  test::MakeImagesFolder(folder_ / "images");
  fs::remove(folder_ / "images" / "camera.yaml");
  test::WriteText(folder_ / "images" / "slam.yaml",
                  "Camera.fx: 40\nCamera.fy: 41\nCamera.cx: 24\nCamera.cy: 16\nCamera.bf: 10\nCamera.fps: 10\n");
  const auto dataset = OpenImagesDataset((folder_ / "images").string());
  EXPECT_EQ(dataset->size(), 3);
  EXPECT_DOUBLE_EQ(dataset->rig().baseline_m, 0.25);
  EXPECT_EQ(dataset->rig().left.width_px, 48) << "the size of the images, where the file tells none";
}

TEST_F(ForeignCalibrationTest, OrderOfRosFilesDoesNotMatter) {
  const std::vector<std::string> paths = WriteAll(RigCalled("left.yaml"));
  ExpectTheRig(ReadForeignCalibration({paths[1], paths[0]}, kSize).rig, "right, left");
}

TEST_F(ForeignCalibrationTest, OtherLenses) {
  const std::string kalibr = RigCalled("camchain.yaml").files[0].text;
  std::string sphere = kalibr;
  for (int i = 0; i < 2; ++i) {
    sphere = Replaced(sphere, "camera_model: pinhole", "camera_model: ds");
    sphere = Replaced(sphere, "distortion_model: radtan", "distortion_model: none");
    sphere = Replaced(sphere, i == 0 ? "[458.5," : "[459.5,", i == 0 ? "[-0.2, 0.6, 458.5," : "[-0.1, 0.5, 459.5,");
  }
  const RigCalibration ds = ReadForeignCalibration({Write("ds.yaml", sphere)}, kSize).rig;
  EXPECT_EQ(ds.left.model, "double_sphere");
  EXPECT_THAT(ds.right.distortion, testing::ElementsAre(-0.1, 0.5));
  EXPECT_EQ(ds.right.fx_px, 459.5);

  const std::string orb = Replaced(RigCalled("orb_slam3.yaml").files[0].text, "PinHole", "KannalaBrandt8");
  std::string fisheye = orb;
  for (const std::string camera : {"Camera1", "Camera2"}) {
    fisheye = Replaced(fisheye, camera + ".p1", camera + ".k3");
    fisheye = Replaced(fisheye, camera + ".p2", camera + ".k4");
  }
  const RigCalibration kb = ReadForeignCalibration({Write("kb.yaml", fisheye)}, kSize).rig;
  EXPECT_EQ(kb.left.model, "equidistant");
  EXPECT_THAT(kb.left.distortion, testing::ElementsAre(-0.28, 0.07, 0.0002, -0.0001));

  const std::vector<std::string> ros = WriteAll(RigCalled("left.yaml"));
  Write("right.yaml", Replaced(RigCalled("left.yaml").files[1].text, "0.0004, 0.0, 0.0, 0.0, 0.0",
                               "0.0004, 0.01, 0.02, 0.03, 0.04"));
  const RigCalibration rational = ReadForeignCalibration(ros, kSize).rig;
  EXPECT_EQ(rational.right.model, "rational");
  EXPECT_THAT(rational.right.distortion, testing::ElementsAre(-0.27, 0.06, -0.0003, 0.0004, 0.01, 0.02, 0.03, 0.04));
}

TEST_F(ForeignCalibrationTest, MistakesAreNamed) {
  const std::vector<std::string> ros = WriteAll(RigCalled("left.yaml"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({ros[0]}, kSize); }),
              AllOf(HasSubstr("left.yaml"), HasSubstr("give the files of the left and the right one")));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({ros[0], ros[0]}, kSize); }), HasSubstr("not as a pair"));

  const std::vector<std::string> zed = WriteAll(RigCalled("SN1234.conf"));
  EXPECT_THAT(ErrorOf([&] {
                ReadForeignCalibration(zed, {0, 0});
              }),
              AllOf(HasSubstr("672x376"), HasSubstr("--size")));
  EXPECT_THAT(ErrorOf([&] {
                ReadForeignCalibration(zed, {1280, 720});
              }),
              HasSubstr("cx of [LEFT_CAM_HD] is missing"));
  Write("SN1234.conf", Replaced(RigCalled("SN1234.conf").files[0].text, "cy=188.75", "cy=188,75"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration(zed, kSize); }), HasSubstr("SN1234.conf:9: cy = '188,75'"));

  const auto& opencv = RigCalled("intrinsics.yml").files;
  const std::string sizeless = Write(
      "intrinsics.yml", Replaced(Replaced(opencv[0].text, "image_width: 672\n", ""), "image_height: 376\n", ""));
  const std::string extrinsics = Write("extrinsics.yml", opencv[1].text);
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({sizeless, extrinsics}, {0, 0}); }), HasSubstr("--size"));
  ExpectTheRig(ReadForeignCalibration({sizeless, extrinsics}, kSize).rig, "size of the images");
  Write("extrinsics.yml", Replaced(opencv[1].text, "-0.118619590656", "0.118619590656"));
  EXPECT_THAT(ErrorOf([&] {
                ReadForeignCalibration({sizeless, extrinsics}, kSize);
              }),
              HasSubstr("are left and right exchanged?"));

  const std::string other = Write("other.yaml", "name: nothing\n");
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({other}, kSize); }),
              HasSubstr("no calibration of a known format"));
}

TEST_F(ForeignCalibrationTest, OrbSlamFilesThatAreNoRectifiedPair) {
  const std::string pair = "Camera.fx: 400\nCamera.fy: 400\nCamera.cx: 330\nCamera.cy: 190\nCamera.bf: 50\n";
  const auto error = [&](const std::string& more) {
    const std::string path = Write("orb.yaml", pair + more);
    return ErrorOf([&] { ReadForeignCalibration({path}, kSize); });
  };
  EXPECT_DOUBLE_EQ(ReadForeignCalibration({Write("orb.yaml", pair + "Camera.k1: 0.0\n")}, kSize).rig.baseline_m,
                   0.125);
  EXPECT_THAT(error("Camera.k1: 0.2\n"), AllOf(HasSubstr("Camera.k1"), HasSubstr("LEFT.K")));
  EXPECT_THAT(error("DepthMapFactor: 5000\n"), HasSubstr("RGB-D"));
  EXPECT_THAT(error("Tlr: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0]\n"), HasSubstr("Stereo.T_c1_c2"));
}

TEST_F(ForeignCalibrationTest, SeveralCalibrationsInAFolderAreNotGuessed) {
  WriteAll(RigCalled("camchain.yaml"));
  WriteAll(RigCalled("stella.yaml"));
  EXPECT_THAT(ErrorOf([&] { CalibrationOf(folder_.string()); }),
              AllOf(HasSubstr("camchain.yaml"), HasSubstr("stella.yaml"), HasSubstr("from: FILE")));
}

}  // namespace
}  // namespace plslam
