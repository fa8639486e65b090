// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/calibrations/foreign_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/datasets/camera_file.h"
#include "core/datasets/images_dataset.h"
#include "core/datasets/open_dataset.h"
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
    for (const test::ForeignFile& file : rig.beside) Write(file.name, file.text);
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
    EXPECT_TRUE(read.notes.empty()) << read.notes.front();
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
    for (const test::ForeignFile& file : rig.beside) test::WriteText(dataset / file.name, file.text);
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
  EXPECT_THAT(error("Tlr: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0]\n"), HasSubstr("Camera2.fx is missing"));
  EXPECT_THAT(error("Camera.type: KannalaBrandt8\nCamera.k4: 0.1\n"), HasSubstr("Tlr (with Camera2) is missing"));
  Write("orb.yaml", Replaced(pair, "Camera.bf: 50\n", ""));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({folder_ / "orb.yaml"}, kSize); }),
              HasSubstr("Camera.bf is missing, so that these are settings of one camera"));
  const std::string matrices = RigCalled("orb_slam2_no_blanks.yaml").files[0].text;
  const std::string copied = Write("copied.yaml", Replaced(matrices, "Camera.fx: 400.0", "Camera.fx: 859.0"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({copied}, kSize); }),
              HasSubstr("copied.yaml:2: Camera.fx = 859 is not the 400 of LEFT.P"));
}

TEST_F(ForeignCalibrationTest, RgbdSettingsOfOrbSlam) {
  const std::string camera = "Camera.fx: 400\nCamera.fy: 401\nCamera.cx: 330\nCamera.cy: 190\nCamera.bf: 40\n";
  const std::string distortion = "Camera.k1: 0.26\nCamera.k2: -0.95\nCamera.p1: -0.005\nCamera.p2: 0.002\n";
  const std::string path = Write("tum1.yaml", "%YAML:1.0\n" + camera + distortion + "DepthMapFactor: 5000.0\n");
  const RigCalibration rig = ReadForeignCalibration({path}, kSize).rig;
  EXPECT_EQ(rig.kind, RigCalibration::Kind::kRgbd);
  EXPECT_EQ(rig.depth_units_per_m, 5000.0);
  EXPECT_DOUBLE_EQ(rig.baseline_m, 0.1);
  EXPECT_THAT(rig.left.distortion, testing::ElementsAre(0.26, -0.95, -0.005, 0.002));
  const RigCalibration again = ReadCameraFile(Write("own.yaml", CameraFileText(rig)), {0, 0});
  EXPECT_EQ(again.kind, rig.kind);
  EXPECT_EQ(again.left.distortion, rig.left.distortion);
  EXPECT_EQ(again.depth_units_per_m, 5000.0);

  const std::string v1 = Write("d435i.yaml",
                               "Camera.type: \"PinHole\"\nCamera1.fx: 617\nCamera1.fy: 618\nCamera1.cx: 324\n"
                               "Camera1.cy: 242\nCamera.width: 640\nCamera.height: 480\nStereo.b: 0.0745\n"
                               "RGBD.DepthMapFactor: 1000.0\n");
  EXPECT_EQ(ReadForeignCalibration({v1}, {}).rig.depth_units_per_m, 1000.0);

  test::MakeImagesFolder(folder_ / "images");
  fs::remove(folder_ / "images" / "camera.yaml");
  test::WriteText(
      folder_ / "images" / "tum1.yaml",
      "Camera.fps: 30\n" + Replaced(Replaced(camera, "330", "24"), "190", "16") + "DepthMapFactor: 5000.0\n");
  EXPECT_THAT(ErrorOf([&] { OpenImagesDataset((folder_ / "images").string()); }),
              AllOf(HasSubstr("tum1.yaml: is of an RGB-D camera"), HasSubstr("images of a stereo pair")));
}

TEST_F(ForeignCalibrationTest, StellaSettingsThatAreNotRectified) {
  const std::string pair =
      "Camera:\n  setup: stereo\n  model: perspective\n  fx: 400\n  fy: 400\n  cx: 330\n"
      "  cy: 190\n  focal_x_baseline: 50\n  k1: 0.0\n";
  const auto error = [&](const std::string& from, const std::string& to) {
    const std::string path = Write("stella.yaml", Replaced(pair, from, to));
    return ErrorOf([&] { ReadForeignCalibration({path}, kSize); });
  };
  EXPECT_DOUBLE_EQ(ReadForeignCalibration({Write("stella.yaml", pair)}, kSize).rig.baseline_m, 0.125);
  EXPECT_THAT(error("k1: 0.0", "k1: -0.28"), AllOf(HasSubstr(":9: Camera.k1 = -0.28"), HasSubstr("StereoRectifier")));
  EXPECT_THAT(error("perspective", "fisheye"), HasSubstr("Camera.model 'fisheye' is not perspective"));
  EXPECT_THAT(error("perspective", "equirectangular"), HasSubstr("'equirectangular' is not perspective"));
  EXPECT_THAT(error("setup: stereo", "setup: monocular"), HasSubstr("'monocular' is not stereo"));
}

TEST_F(ForeignCalibrationTest, UnitsAreStatedOrAskedFor) {
  const auto& opencv = RigCalled("intrinsics.yml").files;
  const std::string in_mm =
      Replaced(opencv[1].text, "-0.118619590656, -0.035, -0.018149179392", "-118.619590656, -35, -18.149179392");
  const std::vector<std::string> paths{Write("intrinsics.yml", opencv[0].text), Write("extrinsics.yml", in_mm)};
  ExpectTheRig(ReadForeignCalibration(paths, kSize, MetresOf("mm")).rig, "mm");
  EXPECT_EQ(MetresOf("inch"), std::nullopt);
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration(paths, kSize); }), HasSubstr("125 m"));

  Write("extrinsics.yml",
        Replaced(opencv[1].text, "-0.118619590656, -0.035, -0.018149179392", "-11.8619590656, -3.5, -1.8149179392"));
  std::vector<std::string> notes;
  ReadCalibration(paths, kSize, &notes);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_THAT(notes[0], AllOf(HasSubstr("intrinsics.yml: the cameras stand 12.5 m apart"), HasSubstr("`unit: cm`")));
  const std::string own = Write("camera.yaml", "from: [intrinsics.yml, extrinsics.yml]\nunit: cm\n");
  notes.clear();
  ExpectTheRig(ReadCameraFile(own, kSize, &notes), "unit: cm");
  EXPECT_TRUE(notes.empty());
  Write("camera.yaml", "from: [intrinsics.yml, extrinsics.yml]\nunit: m\n");
  EXPECT_DOUBLE_EQ(ReadCameraFile(own, kSize, &notes).baseline_m, 12.5);
  EXPECT_TRUE(notes.empty()) << "the unit is stated";
  Write("camera.yaml", "from: [intrinsics.yml, extrinsics.yml]\nunit: inch\n");
  EXPECT_THAT(ErrorOf([&] { ReadCameraFile(own, kSize); }), HasSubstr("'inch' is none of m, cm, mm"));

  const std::vector<std::string> zed = WriteAll(RigCalled("SN1234.conf"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration(zed, kSize, MetresOf("cm")); }), HasSubstr("unit of their own"));
}

TEST_F(ForeignCalibrationTest, OurFileAboveAMetreIsNoted) {
  const std::string lens = "left: {focal_length_px: [400, 400], principal_point_px: [330, 190]}\n";
  std::vector<std::string> notes;
  ReadCameraFile(Write("camera.yaml", lens + "baseline_m: 0.54\n"), kSize, &notes);
  EXPECT_TRUE(notes.empty());
  ReadCameraFile(Write("camera.yaml", lens + "baseline_m: 12\n"), kSize, &notes);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_THAT(notes[0], HasSubstr("stand 12 m apart: lengths are in metres there"));
}

TEST_F(ForeignCalibrationTest, ProjectionsOfNoRectifiedPair) {
  const auto& ros = RigCalled("left.yaml").files;
  const auto error = [&](const std::string& from, const std::string& to) {
    const std::vector<std::string> paths{Write("left.yaml", ros[0].text),
                                         Write("right.yaml", Replaced(ros[1].text, from, to))};
    return ErrorOf([&] { ReadForeignCalibration(paths, kSize); });
  };
  EXPECT_THAT(error("p: [400.0, 0.0,", "p: [400.0, -44.9,"),
              AllOf(HasSubstr("right.yaml:7"), HasSubstr("P[1] of the right camera_info = -44.9 is not 0")));
  EXPECT_THAT(error("-50.0, 0.0, 400.0", "-50.0, 36.3, 400.0"), HasSubstr("P[4]"));
  EXPECT_THAT(error("p: [400.0, 0.0,", "p: [402.0, 0.0,"),
              HasSubstr("P[0] of camera_info is 400 on the left and 402"));
  EXPECT_THAT(error("0.0, 400.0, 190.0", "0.0, 400.0, 191.0"), HasSubstr("P[6]"));
  EXPECT_THAT(error("rational_polynomial", "thin_prism"), HasSubstr("right.yaml:3: distortion_model 'thin_prism'"));
  const std::vector<std::string> verged{
      Write("left.yaml", ros[0].text),
      Write("right.yaml", Replaced(ros[1].text, "p: [400.0, 0.0, 330.0", "p: [400.0, 0.0, 335.0"))};
  ExpectTheRig(ReadForeignCalibration(verged, kSize).rig, "cx may differ");

  // A converter of KITTI's colour cameras writes this: both stand beside the first grey camera, not quite level.
  const std::string identity = "rectification_matrix: {data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n";
  const std::string head = "image_width: 1242\nimage_height: 375\nK: [721.5, 0, 609.5, 0, 721.5, 172.5, 0, 0, 1]\n";
  const std::vector<std::string> kitti{
      Write("left.yaml", head + identity + "P: [721.5, 0, 609.5, 44.5, 0, 721.5, 172.5, 0.25, 0, 0, 1, 0.003]\n"),
      Write("right.yaml", head + identity + "P: [721.5, 0, 609.5, -339.5, 0, 721.5, 172.5, 2, 0, 0, 1, 0.0025]\n")};
  const SE3 T_l_r = ReadForeignCalibration(kitti, {}).rig.right.T_b_cam;
  EXPECT_NEAR(T_l_r.translation().x(), (44.5 + 339.5 - 609.5 * 0.0005) / 721.5, 1e-12);
  EXPECT_NEAR(T_l_r.translation().y(), (0.25 - 2 - 172.5 * 0.0005) / 721.5, 1e-12);
  EXPECT_NEAR(T_l_r.translation().z(), 0.0005, 1e-12);
}

TEST_F(ForeignCalibrationTest, CameraInfoOfBinnedImagesAndOfAPart) {
  const auto& ros = RigCalled("left.yaml").files;
  const std::string binned = "binning_x: 2\nbinning_y: 2\n";
  const std::string part = "roi: {x_offset: 100, y_offset: 40, height: 200, width: 400, do_rectify: false}\n";
  const auto read = [&](const std::string& more, const ImageSize& size) {
    const std::vector<std::string> paths{Write("left.yaml", ros[0].text + more),
                                         Write("right.yaml", ros[1].text + more)};
    return ReadForeignCalibration(paths, size).rig;
  };
  const RigCalibration half = read(binned, {});
  EXPECT_EQ(half.left.width_px, 336);
  EXPECT_EQ(half.left.fx_px, 458.5 / 2);
  EXPECT_EQ(half.right.cy_px, 186.5 / 2);
  EXPECT_NEAR(half.baseline_m, 0.125, 1e-12);
  const RigCalibration cut = read(part, {400, 200});
  EXPECT_EQ(cut.left.height_px, 200);
  EXPECT_EQ(cut.left.cx_px, 335.5 - 100);
  EXPECT_EQ(cut.left.fx_px, 458.5);
  const RigCalibration both = read(binned + part, {});
  EXPECT_EQ(both.right.width_px, 200);
  EXPECT_EQ(both.right.cy_px, (186.5 - 40) / 2);
  ExpectTheRig(read(binned, kSize), "a driver that bins in the camera");
  EXPECT_THAT(ErrorOf([&] {
                read(binned, {320, 240});
              }),
              HasSubstr("of 672 x 376 pixels (336 x 188 with its binning and region of interest), but the images "
                        "have 320 x 240"));
  EXPECT_THAT(ErrorOf([&] { read("roi: {x_offset: 400, y_offset: 0, height: 200, width: 400}\n", {}); }),
              HasSubstr("is none of its 672 x 376 pixels"));
}

TEST_F(ForeignCalibrationTest, CameraInfoWithoutDistortion) {
  const auto& ros = RigCalled("left.yaml").files;
  const std::string none =
      Replaced(Replaced(ros[0].text, "cols: 5", "cols: 0"), "[-0.28, 0.07, 0.0002, -0.0001, 0]", "[]");
  const std::vector<std::string> paths{Write("left.yaml", Replaced(none, "distortion_model: plumb_bob\n", "")),
                                       Write("right.yaml", ros[1].text)};
  EXPECT_EQ(ReadForeignCalibration(paths, kSize).rig.left.model, "pinhole");
}

TEST_F(ForeignCalibrationTest, ZedRotationOfItsResolution) {
  const std::string text = RigCalled("SN1234.conf").files[0].text;
  const auto error = [&](const std::string& changed) {
    const std::string path = Write("SN.conf", changed);
    return ErrorOf([&] { ReadForeignCalibration({path}, kSize); });
  };
  EXPECT_THAT(error(Replaced(text, "RX_VGA", "RX_2K")), HasSubstr("RX_VGA of [STEREO] is missing"));
  EXPECT_THAT(error(Replaced(text, "CV_VGA", "CV_2K")), HasSubstr("CV_VGA of [STEREO] is missing"));
  EXPECT_THAT(error(Replaced(text, "TY_VGA", "TY_2K")), HasSubstr("TY_VGA of [STEREO] is missing"));
  EXPECT_THAT(error(Replaced(text, "k1=-0.28\n", "")), HasSubstr("k1 of [LEFT_CAM_VGA] is missing"));
  const std::string left = "k1=-0.28\nk2=0.07\np1=0.0002\np2=-0.0001\nk3=0\n";
  const std::string right = "k1=-0.27\nk2=0.06\np1=-0.0003\np2=0.0004\nk3=0\n";
  const std::string later =
      Replaced(Replaced(text, left, ""), right, "") + "[LEFT_DISTO]\n" + left + "[RIGHT_DISTO]\n" + right;
  ExpectTheRig(ReadForeignCalibration({Write("SN.conf", later)}, kSize).rig, "distortion of all resolutions");
  const std::string bare = Write("SN.conf", Replaced(Replaced(text, "TY_VGA", "TY"), "TZ_VGA", "TZ"));
  ExpectTheRig(ReadForeignCalibration({bare}, kSize).rig, "TY and TZ of all resolutions");
}

TEST_F(ForeignCalibrationTest, TwoCamerasOfThree) {
  const std::string kalibr = RigCalled("camchain.yaml").files[0].text;
  const std::string third =
      "cam2:\n  T_cn_cnm1: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0]\n  camera_model: pinhole\n"
      "  distortion_coeffs: [0, 0, 0, 0]\n  distortion_model: radtan\n  intrinsics: [600, 600, 320, 240]\n"
      "  resolution: [640, 480]\n";
  // The first is the colour camera, 5 cm to the left of the pair.
  const std::string first =
      "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0, 0, 0, 0]\n"
      "  distortion_model: radtan\n  intrinsics: [600, 600, 320, 240]\n  resolution: [640, 480]\n";
  const std::string pose = "  T_cn_cnm1: [1, 0, 0, -0.05, 0, 1, 0, 0, 0, 0, 1, 0]\n";
  const std::string pair = Replaced(Replaced(kalibr, "cam1:", "cam2:"), "cam0:\n", "cam1:\n" + pose);
  for (const auto& [text, note] : {std::pair(kalibr + third, "cam0 and cam1 are taken for the stereo pair, cam2 is"),
                                   std::pair(first + pair, "cam1 and cam2 are taken for the stereo pair, cam0 is")}) {
    const ForeignCalibration read = ReadForeignCalibration({Write("three.yaml", text)}, kSize);
    ExpectTheRig(read.rig, note);
    ASSERT_EQ(read.notes.size(), 1U) << note;
    EXPECT_THAT(read.notes[0], HasSubstr(note));
  }
  std::string alike =
      kalibr + Replaced(Replaced(third, "[600, 600, 320, 240]", "[459, 458, 336, 188]"), "640, 480", "672, 376");
  alike = Replaced(alike, "[1, 0, 0, 0.1,", "[1, 0, 0, -0.1,");
  const std::string several = Write("three.yaml", alike);
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({several}, kSize); }),
              AllOf(HasSubstr("has 3 cameras, and several pairs could be meant"), HasSubstr("keep the two")));
}

TEST_F(ForeignCalibrationTest, LensesOfOtherPrograms) {
  const test::ForeignRig& vins = RigCalled("vins.yaml");
  WriteAll(vins);
  Write("cam0_pinhole.yaml",
        "%YAML:1.0\n---\nmodel_type: KANNALA_BRANDT\nimage_width: 672\nimage_height: 376\nprojection_parameters:\n"
        "   k2: -0.007\n   k3: 0.042\n   k4: -0.03\n   k5: 0.006\n   mu: 286.25\n   mv: 286.5\n   u0: 330.5\n"
        "   v0: 190.75\n");
  const RigCalibration fisheye = ReadForeignCalibration({folder_ / "vins.yaml"}, kSize).rig;
  EXPECT_EQ(fisheye.left.model, "equidistant");
  EXPECT_THAT(fisheye.left.distortion, testing::ElementsAre(-0.007, 0.042, -0.03, 0.006));
  EXPECT_EQ(fisheye.left.cy_px, 190.75);
  Write("cam0_pinhole.yaml", Replaced(vins.beside[0].text, "PINHOLE", "MEI"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({folder_ / "vins.yaml"}, kSize); }),
              HasSubstr("cam0_pinhole.yaml:3: model_type 'MEI' is not read"));
  Write("vins.yaml", Replaced(vins.files[0].text, "cam0_pinhole.yaml", "../cam0_pinhole.yaml"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({folder_ / "vins.yaml"}, kSize); }),
              HasSubstr("leaves the folder"));

  const std::string air =
      Replaced(RigCalled("airslam.yaml").files[0].text, "distortion_type: 1", "distortion_type: 2");
  const RigCalibration air_fisheye = ReadForeignCalibration({Write("air.yaml", air)}, kSize).rig;
  EXPECT_EQ(air_fisheye.right.model, "equidistant");
  EXPECT_EQ(air_fisheye.right.distortion.size(), 4U);
  const std::string plain = Write("pl.yaml",
                                  "cam0:\n  cam_fx: 721.5\n  cam_fy: 721.5\n  cam_cx: 609.5\n  cam_cy: 172.8\n"
                                  "  cam_d0: 0.0\n  cam_d1: 0.0\n  cam_d2: 0.0\n  cam_d3: 0.0\n  cam_bl: 0.537\n"
                                  "  cam_height: 375\n  cam_width: 1242\n  cam_model: Pinhole\n");
  EXPECT_DOUBLE_EQ(ReadForeignCalibration({plain}, {}).rig.baseline_m, 0.537);
  const std::string typed =
      Write("pl.yaml", Replaced(RigCalled("pl_slam.yaml").files[0].text, "cam_bl: 0.125", "cam_bl: 0.13"));
  EXPECT_THAT(ReadForeignCalibration({typed}, {}).notes,
              testing::ElementsAre(HasSubstr("cam_bl = 0.13 is not the length 0.125000 of t")));
}

TEST_F(ForeignCalibrationTest, FilesThatAreNoPairAreNamed) {
  const auto why = [&](const std::string& name, const std::string& text) {
    return ErrorOf([&] { ReadForeignCalibration({Write(name, text)}, kSize); });
  };
  EXPECT_THAT(why("a.yaml", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 812\n"),
              HasSubstr("a.yaml: is a pointer of Git LFS, not the file itself: fetch it with `git lfs pull`"));
  EXPECT_THAT(why("a.xml", "<?xml version=\"1.0\"?>\n<opencv_storage>\n"),
              HasSubstr("write the calibration as YAML"));
  EXPECT_THAT(why("a.yaml", "%YAML:1.0\n---\nmodel_type: PINHOLE\nprojection_parameters: {fx: 1}\n"),
              HasSubstr("give the settings of VINS-Fusion"));
  EXPECT_THAT(why("a.yaml", "rotation_matrix: {data: []}\ntranslation_matrix: {data: []}\n"),
              HasSubstr("NAME_left.yaml and NAME_right.yaml"));
  EXPECT_THAT(why("a.yml", "camera_matrix: {data: []}\ndistortion_coefficients: {data: []}\n"),
              HasSubstr("is of one camera: a stereo pair needs both cameras"));
  const std::vector<std::string> kimera = WriteAll(RigCalled("LeftCameraParams.yaml"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({kimera[0]}, kSize); }),
              HasSubstr("is of one camera: give the files of the left and the right one"));
  EXPECT_THAT(why("a.yaml", "cam0:\n  Kl: [1, 1, 1, 1]\n  Kr: [1, 1, 1, 1]\n"),
              AllOf(HasSubstr("nothing tells how the cameras are turned"), HasSubstr("(read as PL-SLAM)")));
}

TEST_F(ForeignCalibrationTest, AFolderNamesTheSettingsThatItHas) {
  test::MakeImagesFolder(folder_ / "images");
  fs::remove(folder_ / "images" / "camera.yaml");
  const auto error = [&](const std::string& settings) {
    test::WriteText(folder_ / "images" / "settings.yaml", settings);
    return ErrorOf([&] { OpenDataset((folder_ / "images").string(), ""); });
  };
  EXPECT_THAT(error("%YAML:1.0\nCamera.fx: 400\nCamera.fy 400\nCamera.cx: 330\n"),
              AllOf(HasSubstr("is no dataset of a known kind"), HasSubstr("settings.yaml:3: not valid YAML: no `key: "
                                                                          "value` ('Camera.fy 400')")));
  EXPECT_THAT(error("model_type: MEI\nprojection_parameters: {}\n"), HasSubstr("settings.yaml: is of one camera"));
  EXPECT_THAT(error("name: nothing\n"), testing::Not(HasSubstr("settings.yaml")));
}

TEST_F(ForeignCalibrationTest, KeysThatStandTwice) {
  const std::string text = RigCalled("orb_slam2.yaml").files[0].text;
  ExpectTheRig(
      ReadForeignCalibration({Write("a.yaml", text + "Viewer.PointSize: 2\nViewer.PointSize: 3\n")}, kSize).rig,
      "a key that is not read");
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({Write("a.yaml", text + "Camera.bf: 51\n")}, kSize); }),
              HasSubstr("key 'Camera.bf' stands here twice"));
}

TEST_F(ForeignCalibrationTest, SeveralCalibrationsInAFolderAreNotGuessed) {
  WriteAll(RigCalled("camchain.yaml"));
  WriteAll(RigCalled("stella.yaml"));
  EXPECT_THAT(ErrorOf([&] { CalibrationOf(folder_.string()); }),
              AllOf(HasSubstr("camchain.yaml"), HasSubstr("stella.yaml"), HasSubstr("from: FILE")));
}

}  // namespace
}  // namespace plslam
