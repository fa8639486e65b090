// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/camera_file.h"
#include "core/datasets/images_dataset.h"
#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/foreign_calibration_fixture.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using test::ExpectTheRig;
using testing::AllOf;
using testing::HasSubstr;

class ForeignCalibrationFiles : public test::ForeignCalibrationTest {};

TEST_F(ForeignCalibrationFiles, OneRigIsTheSameInEveryFormat) {
  for (const test::ForeignRig& rig : test::ForeignRigs()) {
    const std::vector<std::string> paths = WriteAll(rig);
    EXPECT_EQ(ForeignFormat(paths.front()), rig.format);
    const ForeignCalibration read = ReadForeignCalibration(paths, kSize);
    EXPECT_EQ(read.format, rig.format);
    EXPECT_FALSE(read.direction.empty());
    EXPECT_TRUE(read.notes.empty());
    ExpectTheRig(read.rig, rig.files.front().name);
  }
}

TEST_F(ForeignCalibrationFiles, RigSurvivesARoundTripThroughOurFile) {
  for (const test::ForeignRig& rig : test::ForeignRigs()) {
    const std::string own = Write("own.yaml", CameraFileText(ReadForeignCalibration(WriteAll(rig), kSize).rig));
    EXPECT_EQ(ForeignFormat(own), "");
    ExpectTheRig(ReadCameraFile(own, {0, 0}), rig.files.front().name);
  }
}

TEST_F(ForeignCalibrationFiles, ForeignFilesInsteadOfOurFile) {
  for (const test::ForeignRig& rig : test::ForeignRigs()) {
    const fs::path dataset = folder_ / ("with " + rig.files.front().name);
    fs::create_directories(dataset);
    for (const test::ForeignFile& file : rig.files) test::WriteText(dataset / file.name, file.text);
    for (const test::ForeignFile& file : rig.beside) test::WriteText(dataset / file.name, file.text);
    ASSERT_TRUE(LooksLikeImages(dataset.string())) << dataset;
    ExpectTheRig(ReadCalibration(CalibrationOf(dataset.string()), kSize), dataset.string());
  }
}

TEST_F(ForeignCalibrationFiles, OurFileMayNameOthers) {
  WriteAll(RigCalled("left.yaml"));
  const std::string own = Write("camera.yaml", "from: [left.yaml, right.yaml]\nname: pair\nrate_hz: 15\n");
  const RigCalibration rig = ReadCameraFile(own, kSize);
  ExpectTheRig(rig, own);
  EXPECT_EQ(rig.name, "pair");
  EXPECT_EQ(rig.rate_hz, 15.0);
  Write("camera.yaml", "from: ../left.yaml\n");
  EXPECT_THAT(ErrorOf([&] { ReadCameraFile(own, kSize); }), HasSubstr("leaves the folder"));
}

TEST_F(ForeignCalibrationFiles, AFolderOfImagesPlays) {
  test::MakeImagesFolder(folder_ / "images");
  fs::remove(folder_ / "images" / "camera.yaml");
  test::WriteText(folder_ / "images" / "slam.yaml",
                  "Camera.fx: 40\nCamera.fy: 41\nCamera.cx: 24\nCamera.cy: 16\nCamera.bf: 10\nCamera.fps: 10\n");
  const auto dataset = OpenImagesDataset((folder_ / "images").string());
  EXPECT_EQ(dataset->size(), 3);
  EXPECT_DOUBLE_EQ(dataset->rig().baseline_m, 0.25);
  EXPECT_EQ(dataset->rig().left.width_px, 48) << "the size of the images, where the file tells none";
}

TEST_F(ForeignCalibrationFiles, LineDelayOfKalibr) {
  const std::string kalibr = RigCalled("camchain.yaml").files[0].text;
  const std::string model = "camera_model: pinhole";
  const auto with = [&](const std::string& left, const std::string& right) {
    const std::string line = "\n  line_delay: ";
    std::string text = Replaced(kalibr, model, "camera_model:  pinhole" + line + left);
    return Write("rolling.yaml", Replaced(text, model, model + line + right));
  };
  const RigCalibration rig = ReadForeignCalibration({with("5e-5", "5e-5")}, kSize).rig;
  EXPECT_NEAR(rig.left.readout_ms, 0.05 * rig.left.height_px, 1e-9);
  const auto error = [&](const std::string& left, const std::string& right) {
    return ErrorOf([&] { ReadForeignCalibration({with(left, right)}, kSize); });
  };
  EXPECT_THAT(error("50000", "50000"), AllOf(HasSubstr("line_delay"), HasSubstr("state it in seconds")));
  EXPECT_THAT(error("5e-5", "4e-5"), AllOf(HasSubstr("line_delay"), HasSubstr("same shutter")));
}

TEST_F(ForeignCalibrationFiles, OtherLenses) {
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

TEST_F(ForeignCalibrationFiles, MistakesAreNamed) {
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
              HasSubstr("not a calibration of a known format"));
}

TEST_F(ForeignCalibrationFiles, SeveralCalibrationsInAFolderAreNotGuessed) {
  WriteAll(RigCalled("camchain.yaml"));
  WriteAll(RigCalled("stella.yaml"));
  EXPECT_THAT(ErrorOf([&] { CalibrationOf(folder_.string()); }),
              AllOf(HasSubstr("camchain.yaml"), HasSubstr("stella.yaml"), HasSubstr("from: FILE")));
}

TEST_F(ForeignCalibrationFiles, UnitsAreGivenOrRequested) {
  const auto& opencv = RigCalled("intrinsics.yml").files;
  const std::string in_mm =
      Replaced(opencv[1].text, "-0.118619590656, -0.035, -0.018149179392", "-118.619590656, -35, -18.149179392");
  const std::vector<std::string> paths{Write("intrinsics.yml", opencv[0].text), Write("extrinsics.yml", in_mm)};
  ExpectTheRig(ReadForeignCalibration(paths, kSize, MetresOf("mm")).rig, "mm");
  EXPECT_EQ(MetresOf("inch"), std::nullopt);
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration(paths, kSize); }), HasSubstr("125 m"));

  Write("extrinsics.yml",
        Replaced(opencv[1].text, "-0.118619590656, -0.035, -0.018149179392", "-11.8619590656, -3.5, -1.8149179392"));
  Notes notes;
  ReadCalibration(paths, kSize, &notes);
  ASSERT_EQ(notes.warnings.size(), 1U);
  EXPECT_THAT(notes.warnings[0],
              AllOf(HasSubstr("intrinsics.yml: the cameras are 12.5 m apart"), HasSubstr("`unit: cm`")));
  const std::string own = Write("camera.yaml", "from: [intrinsics.yml, extrinsics.yml]\nunit: cm\n");
  notes = {};
  ExpectTheRig(ReadCameraFile(own, kSize, &notes), "unit: cm");
  EXPECT_TRUE(notes.empty());
  Write("camera.yaml", "from: [intrinsics.yml, extrinsics.yml]\nunit: m\n");
  EXPECT_DOUBLE_EQ(ReadCameraFile(own, kSize, &notes).baseline_m, 12.5);
  EXPECT_TRUE(notes.empty()) << "the unit is stated";
  Write("camera.yaml", "from: [intrinsics.yml, extrinsics.yml]\nunit: inch\n");
  EXPECT_THAT(ErrorOf([&] { ReadCameraFile(own, kSize); }), HasSubstr("'inch' is not one of m, cm, mm"));

  const std::vector<std::string> zed = WriteAll(RigCalled("SN1234.conf"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration(zed, kSize, MetresOf("cm")); }), HasSubstr("fixed unit"));
}

TEST_F(ForeignCalibrationFiles, OurFileAboveAMetreIsNoted) {
  const std::string lens = "left: {focal_length_px: [400, 400], principal_point_px: [330, 190]}\n";
  Notes notes;
  ReadCameraFile(Write("camera.yaml", lens + "baseline_m: 0.54\n"), kSize, &notes);
  EXPECT_TRUE(notes.empty());
  ReadCameraFile(Write("camera.yaml", lens + "baseline_m: 12\n"), kSize, &notes);
  ASSERT_EQ(notes.warnings.size(), 1U);
  EXPECT_THAT(notes.warnings[0], HasSubstr("are 12 m apart: lengths must be in metres"));
}

}  // namespace
}  // namespace plslam
