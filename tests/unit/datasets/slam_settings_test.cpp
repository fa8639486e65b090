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

class SlamSettingsFile : public test::ForeignCalibrationTest {};

TEST_F(SlamSettingsFile, OrbSlamFilesWithoutARectifiedPair) {
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
              HasSubstr("Camera.bf is missing, so that these are settings of a single camera"));
  const std::string matrices = RigCalled("orb_slam2_no_blanks.yaml").files[0].text;
  const std::string copied = Write("copied.yaml", Replaced(matrices, "Camera.fx: 400.0", "Camera.fx: 859.0"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({copied}, kSize); }),
              HasSubstr("copied.yaml:2: Camera.fx = 859 is not the 400 of LEFT.P"));
}

TEST_F(SlamSettingsFile, RgbdSettingsOfOrbSlam) {
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
              AllOf(HasSubstr("tum1.yaml: is for an RGB-D camera"), HasSubstr("images of a stereo pair")));
}

TEST_F(SlamSettingsFile, UnrectifiedStellaSettings) {
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
  EXPECT_THAT(error("setup: stereo", "setup: monocular"), HasSubstr("'monocular' is neither stereo nor RGBD"));
}

TEST_F(SlamSettingsFile, ZedRotationOfItsResolution) {
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

TEST_F(SlamSettingsFile, TwoCamerasOfThree) {
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
  for (const auto& [text, note] : {std::pair(kalibr + third, "cam0 and cam1 are used as the stereo pair, cam2 is"),
                                   std::pair(first + pair, "cam1 and cam2 are used as the stereo pair, cam0 is")}) {
    const ForeignCalibration read = ReadForeignCalibration({Write("three.yaml", text)}, kSize);
    ExpectTheRig(read.rig, note);
    ASSERT_EQ(read.notes.remarks.size(), 1U) << note;
    EXPECT_THAT(read.notes.remarks[0], HasSubstr(note));
  }
  std::string alike =
      kalibr + Replaced(Replaced(third, "[600, 600, 320, 240]", "[459, 458, 336, 188]"), "640, 480", "672, 376");
  alike = Replaced(alike, "[1, 0, 0, 0.1,", "[1, 0, 0, -0.1,");
  const std::string several = Write("three.yaml", alike);
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({several}, kSize); }),
              AllOf(HasSubstr("has 3 cameras, and several pairs could be meant"), HasSubstr("put the two")));
}

TEST_F(SlamSettingsFile, LensesOfOtherPrograms) {
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
              HasSubstr("cam0_pinhole.yaml:3: model_type 'MEI' is not supported"));
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
  EXPECT_THAT(ReadForeignCalibration({typed}, {}).notes.warnings,
              testing::ElementsAre(HasSubstr("cam_bl = 0.13 is not the length 0.125000 of t")));
}

TEST_F(SlamSettingsFile, FilesWithoutAPairAreNamed) {
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
              HasSubstr("is for one camera: a stereo pair needs both cameras"));
  const std::vector<std::string> kimera = WriteAll(RigCalled("LeftCameraParams.yaml"));
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({kimera[0]}, kSize); }),
              HasSubstr("is for one camera: give the files of the left and the right one"));
  EXPECT_THAT(why("a.yaml", "cam0:\n  Kl: [1, 1, 1, 1]\n  Kr: [1, 1, 1, 1]\n"),
              AllOf(HasSubstr("the rotation between the cameras is unknown"), HasSubstr("(read as PL-SLAM)")));
}

TEST_F(SlamSettingsFile, AFolderNamesTheSettingsThatItHas) {
  test::MakeImagesFolder(folder_ / "images");
  fs::remove(folder_ / "images" / "camera.yaml");
  const auto error = [&](const std::string& settings) {
    test::WriteText(folder_ / "images" / "settings.yaml", settings);
    return ErrorOf([&] { OpenDataset((folder_ / "images").string(), ""); });
  };
  EXPECT_THAT(
      error("%YAML:1.0\nCamera.fx: 400\nCamera.fy 400\nCamera.cx: 330\n"),
      AllOf(HasSubstr("is not a dataset of a known format"), HasSubstr("settings.yaml:3: not valid YAML: no `key: "
                                                                       "value` ('Camera.fy 400')")));
  EXPECT_THAT(error("model_type: MEI\nprojection_parameters: {}\n"), HasSubstr("settings.yaml: is for one camera"));
  EXPECT_THAT(error("name: nothing\n"), testing::Not(HasSubstr("settings.yaml")));
}

TEST_F(SlamSettingsFile, DuplicateKeys) {
  const std::string text = RigCalled("orb_slam2.yaml").files[0].text;
  ExpectTheRig(
      ReadForeignCalibration({Write("a.yaml", text + "Viewer.PointSize: 2\nViewer.PointSize: 3\n")}, kSize).rig,
      "a key that is not read");
  EXPECT_THAT(ErrorOf([&] { ReadForeignCalibration({Write("a.yaml", text + "Camera.bf: 51\n")}, kSize); }),
              HasSubstr("key 'Camera.bf' is repeated"));
}

}  // namespace
}  // namespace plslam
