// SPDX-License-Identifier: BSD-3-Clause
// Calibrations that contradict themselves, or can hardly be meant as they are written.
#include "core/datasets/calibrations/camera_info.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/images_dataset.h"
#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"
#include "tests/unit/datasets/foreign_calibration_fixture.h"
#include "tests/unit/datasets/mcap_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using test::ExpectTheRig;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class DoubtfulCalibration : public test::ForeignCalibrationTest {
 protected:
  ForeignCalibration Read(const std::string& name, const std::string& text) const {
    return ReadForeignCalibration({Write(name, text)}, kSize);
  }
  std::string Error(const std::string& name, const std::string& text) const {
    return ErrorOf([&] { Read(name, text); });
  }
  static std::string TextOf(const std::string& name) { return RigCalled(name).files.front().text; }
};

TEST_F(DoubtfulCalibration, CamchainThatContradictsItself) {
  const std::string lens =
      "  camera_model: pinhole\n  distortion_coeffs: [0, 0, 0, 0]\n  distortion_model: radtan\n"
      "  intrinsics: [458, 457, 336, 188]\n  resolution: [672, 376]\n";
  const auto pose = [](const char* key, const char* x) {
    return std::string("  ") + key + ": [1, 0, 0, " + x + ", 0, 1, 0, 0, 0, 0, 1, 0]\n";
  };
  const std::string left = "cam0:\n" + lens + pose("T_cam_imu", "0") + "cam1:\n" + lens;
  const ForeignCalibration agrees = Read("a.yaml", left + pose("T_cam_imu", "-0.11") + pose("T_cn_cnm1", "-0.1101"));
  EXPECT_TRUE(agrees.notes.empty());
  const ForeignCalibration differs = Read("a.yaml", left + pose("T_cam_imu", "-0.11") + pose("T_cn_cnm1", "-0.22"));
  EXPECT_DOUBLE_EQ(differs.rig.baseline_m, 0.11);
  EXPECT_THAT(differs.notes.warnings,
              ElementsAre(AllOf(HasSubstr("a.yaml:15: T_cn_cnm1 of cam1 contradicts the poses relative to the IMU"),
                                HasSubstr("at 0.2200, "), HasSubstr("at 0.1100, "))));
  EXPECT_THAT(Error("a.yaml", left + pose("T_cam_imu", "-0.11") + pose("T_imu_cam", "0.22")),
              AllOf(HasSubstr("a.yaml:14: T_cam_imu contradicts T_imu_cam"), HasSubstr("at 0.2200, "),
                    HasSubstr("at 0.1100, ")));
  EXPECT_TRUE(Read("a.yaml", left + pose("T_cam_imu", "-0.11") + pose("T_imu_cam", "0.11")).notes.empty());
}

TEST_F(DoubtfulCalibration, DepthAiCameraTypes) {
  const std::string text = TextOf("depthai.json");
  const auto typed = [&](const std::string& type) {
    std::string changed = text;
    for (size_t at = changed.find("\"cameraType\": 0"); at != std::string::npos;
         at = changed.find("\"cameraType\": 0", at + 1)) {
      changed.replace(at, 15, "\"cameraType\": " + type);
    }
    return changed;
  };
  ExpectTheRig(Read("a.json", typed("\"Perspective\"")).rig, "by its name");
  EXPECT_EQ(Read("a.json", typed("\"Fisheye\"")).rig.left.model, "equidistant");
  for (const char* type : {"2", "3", "\"Equirectangular\""}) {
    EXPECT_THAT(Error("a.json", typed(type)), HasSubstr("is neither 0 (perspective) nor 1 (fisheye)")) << type;
  }
}

TEST_F(DoubtfulCalibration, FourCoefficientsOfOpenCv) {
  const std::string camera = "{rows: 3, cols: 3, data: [458, 0, 336, 0, 457, 188, 0, 0, 1]}\n";
  const std::string four = "{rows: 4, cols: 1, data: [-0.01, 0.02, -0.01, 0.002]}\n";
  const std::string text = "image_width: 672\nimage_height: 376\nM1: " + camera + "D1: " + four + "M2: " + camera +
                           "D2: " + four + "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [-0.12, 0, 0]\n";
  const ForeignCalibration plain = Read("a.yml", text);
  EXPECT_EQ(plain.rig.left.model, "radtan");
  EXPECT_TRUE(plain.notes.warnings.empty());
  EXPECT_THAT(plain.notes.remarks,
              ElementsAre(AllOf(HasSubstr("a.yml:4: the 4 numbers of D1 are read as k1, k2, p1, p2"),
                                HasSubstr("`distortion_model: fisheye`"))));
  const ForeignCalibration fisheye = Read("a.yml", text + "distortion_model: fisheye\n");
  EXPECT_EQ(fisheye.rig.right.model, "equidistant");
  EXPECT_TRUE(fisheye.notes.empty());
  // The rounding of a solver.
  EXPECT_EQ(Read("a.yml", Replaced(text, "[458, 0,", "[458, 1.2e-14,")).rig.left.fx_px, 458.0);
  EXPECT_THAT(Error("a.yml", Replaced(text, "[458, 0,", "[458, 0.5,")), HasSubstr("skew is not supported"));
  EXPECT_EQ(Read("a.yml", "\xEF\xBB\xBF%YAML:1.0\n---\n" + text).rig.left.fx_px, 458.0) << "a byte order mark";
}

TEST_F(DoubtfulCalibration, RectifiedSettingsWithDistortion) {
  const std::string text =
      "File.version: \"1.0\"\nCamera.type: \"Rectified\"\nCamera1.fx: 400\nCamera1.fy: 400\nCamera1.cx: 330\n"
      "Camera1.cy: 190\nCamera1.k1: -0.2\nCamera.width: 672\nCamera.height: 376\nStereo.b: 0.12\n";
  EXPECT_THAT(Read("a.yaml", text).notes.warnings,
              ElementsAre(HasSubstr("a.yaml:7: Camera1.k1 = -0.2 is not applied")));
  EXPECT_TRUE(Read("a.yaml", Replaced(text, "k1: -0.2", "k1: 0.0")).notes.empty());
}

TEST_F(DoubtfulCalibration, StellaSettingsOfADepthCamera) {
  const std::string text =
      "Camera:\n  setup: RGBD\n  model: perspective\n  fx: 400\n  fy: 401\n  cx: 330\n  cy: 190\n  k1: -0.28\n  k2: "
      "0.07\n"
      "  p1: 0.0\n  p2: 0.0\n  k3: 0.0\n  fps: 30\n  cols: 672\n  rows: 376\n  focal_x_baseline: 50\n";
  for (const char* factor :
       {"  depthmap_factor: 5000\n", "depthmap_factor: 5000\n", "Preprocessing:\n  depthmap_factor: 5000\n"}) {
    const RigCalibration rig = Read("a.yaml", text + factor).rig;
    EXPECT_EQ(rig.kind, RigCalibration::Kind::kRgbd);
    EXPECT_EQ(rig.depth_units_per_m, 5000.0);
    EXPECT_EQ(rig.left.model, "radtan");
    EXPECT_EQ(rig.right.fy_px, 401.0);
    EXPECT_EQ(rig.rate_hz, 30.0);
    EXPECT_DOUBLE_EQ(rig.baseline_m, 0.125);
  }
  EXPECT_THAT(Error("a.yaml", text), HasSubstr("Preprocessing.depthmap_factor is missing"));
}

TEST_F(DoubtfulCalibration, CameraInfoThatIsNotCalibrated) {
  const auto& ros = RigCalled("left.yaml").files;
  const auto error = [&](const std::string& left, const std::string& right) {
    const std::vector<std::string> paths{Write("left.yaml", left), Write("right.yaml", right)};
    return ErrorOf([&] { ReadForeignCalibration(paths, kSize); });
  };
  const std::string K = "[458.5, 0, 335.5, 0, 457.25, 188.75, 0, 0, 1]",
                    P = "[400, 0, 330, 0, 0, 400, 190, 0, 0, 0, 1, 0]";
  EXPECT_THAT(error(Replaced(ros[0].text, K, "[0, 0, 0, 0, 0, 0, 0, 0, 0]"), ros[1].text),
              HasSubstr("left.yaml:4: camera_matrix is all 0: the camera is not calibrated"));
  EXPECT_THAT(error(Replaced(ros[0].text, P, "[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]"), ros[1].text),
              HasSubstr("projection_matrix is all 0: the camera is not calibrated"));
  EXPECT_THAT(
      error(ros[0].text, Replaced(ros[1].text, "330.0, -50.0", "330.0, 50.0")),
      HasSubstr("P[3] of camera_info is 0 on the left and 50 on the right, where it is 0 and -fx b (below 0)"));
}

TEST_F(DoubtfulCalibration, CameraMatrixOfAnotherScale) {
  const auto& ros = RigCalled("left.yaml").files;
  const std::vector<std::string> paths{
      Write("left.yaml", Replaced(ros[0].text, "[458.5, 0, 335.5, 0, 457.25, 188.75, 0, 0, 1]",
                                  "[917, 0, 671, 0, 914, 377, 0, 0, 1]")),
      Write("right.yaml", ros[1].text)};
  const RigCalibration rig = ReadForeignCalibration(paths, kSize).rig;
  Notes notes;
  WarnOfOtherScale("left.yaml", rig, &notes);
  EXPECT_THAT(notes.warnings,
              ElementsAre(AllOf(HasSubstr("left.yaml: the principal point of the left camera, 671.0, 377.0"),
                                HasSubstr("images 2 times as large"))));
  Notes none;
  WarnOfOtherScale("left.yaml", ReadForeignCalibration(WriteAll(RigCalled("left.yaml")), kSize).rig, &none);
  EXPECT_TRUE(none.empty());
}

TEST_F(DoubtfulCalibration, BaselinesBeyondAllBoundsAskForTheUnit) {
  const std::string text = Replaced(TextOf("orb_slam3.yaml"), ", 0.12, ", ", 120.0, ");
  EXPECT_THAT(Error("a.yaml", text), AllOf(HasSubstr("the cameras stand 120 m apart, more than 100 m"),
                                           HasSubstr("--unit mm"), HasSubstr("`unit: mm` beside `from: a.yaml`")));
  EXPECT_NEAR(ReadForeignCalibration({Write("a.yaml", text)}, kSize, 1e-3).rig.baseline_m, 0.12, 1e-3);
}

TEST_F(DoubtfulCalibration, FilesThatAreNoForeignCalibration) {
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 812\n";
  for (const char* name : {"a.conf", "a.xml", "a.json", "a.yaml", "a.ini"}) {
    EXPECT_THAT(Error(name, pointer), HasSubstr(std::string(name) + ": is a pointer of Git LFS")) << name;
  }
  EXPECT_THAT(Error("a.xml", "\xEF\xBB\xBF<?xml version=\"1.0\"?>\n"), HasSubstr("is XML: write"));
  EXPECT_THAT(Error("a.ini", "\xEF\xBB\xBF[Left Camera]\nfx=1\n"), HasSubstr("is an INI file"));
  EXPECT_THAT(Error("a.ini", "[image]\n\nwidth\n640\n"), HasSubstr("is an INI file"));
  const std::string own =
      "left:\n  focal_length_px: [280, 280]\n  principal_point_px: [159.5, 119.5]\nbaseline_m: 0.12\n";
  EXPECT_THAT(Error("a.yaml", own), HasSubstr("a.yaml: is in plslam's own format already"));
  EXPECT_THAT(Error("a.yaml", "from: stereo.yml\nunit: mm\n"), HasSubstr("names other files by `from`: give those"));
}

TEST(RectifiedTopics, AreNamedByWholePartsOfTheirPath) {
  for (const char* name :
       {"/left/image_rect#sensor_msgs.Image", "/left/image_rect_color", "/rect/left", "/l/rectified",
        "/zed/left/gray/rect/image", "/camera/infra1/image_rect_raw", "/l/image_rect/compressed", "image_rect"}) {
    EXPECT_TRUE(NamesRectified(name)) << name;
  }
  for (const char* name : {"/direct/left/image_raw", "/director/image", "/corrected/left/image",
                           "/left/image_corrected", "/rectangle/left", "/left/image_rectangle", "", "/"}) {
    EXPECT_FALSE(NamesRectified(name)) << name;
  }
}

class RecordedCameraInfo : public testing::Test {
 protected:
  std::unique_ptr<Dataset> Open(const test::RecordingOptions& options) const {
    test::MakeMcapFile(path_, options);
    return OpenDataset(path_, "");
  }

  test::TemporaryFolder folder_;
  const std::string path_ = (folder_.path() / "a.mcap").string();
};

TEST_F(RecordedCameraInfo, DistortionOfRectifiedTopics) {
  const auto raw = Open({.left = "/direct/left/image_raw", .right = "/direct/right/image_raw"});
  EXPECT_EQ(raw->rig().left.model, "radtan");
  EXPECT_TRUE(raw->Notes().empty());
  const auto rectified = Open({.left = "/left/image_rect", .right = "/right/image_rect"});
  EXPECT_EQ(rectified->rig().left.model, "pinhole");
  EXPECT_THAT(rectified->Notes().warnings,
              ElementsAre(AllOf(HasSubstr("D of the camera_info of /left/image_rect is not 0, and is not applied"),
                                HasSubstr("FILE?camera=camera.yaml"))));
  EXPECT_TRUE(Open({.left = "/left/image_rect", .right = "/right/image_rect", .distortion = {}})->Notes().empty());
}

TEST_F(RecordedCameraInfo, CamerasThatAreNotCalibrated) {
  EXPECT_THAT(ErrorOf([&] { Open({.info_factor = [](int) { return 0.0; }}); }),
              HasSubstr("P of the left camera_info is all 0, so that the camera is not calibrated"));
  EXPECT_THAT(ErrorOf([&] { Open({.p_right = 5.0}); }),
              HasSubstr("P[3] of camera_info is 0 on the left and 5 on the"));
}

TEST_F(RecordedCameraInfo, ZerosBeforeTheCalibrationAreSkipped) {
  const auto late = Open({.info_factor = [](int frame) { return frame == 0 ? 0.0 : 1.0; }});
  EXPECT_EQ(late->rig().left.fx_px, 40.0);
  EXPECT_TRUE(late->Notes().empty());
}

TEST_F(RecordedCameraInfo, CalibrationThatChanges) {
  const auto zoomed = Open({.info_factor = [](int frame) { return frame == 0 ? 1.0 : 1.1; }});
  EXPECT_EQ(zoomed->rig().left.fx_px, 40.0);
  EXPECT_THAT(zoomed->Notes().warnings,
              ElementsAre(HasSubstr("/cam0/camera_info changes, and all frames are played with the first one"),
                          HasSubstr("/cam1/camera_info changes")));
}

TEST(DepthFactor, DepthsThatAreTooLarge) {
  const test::TemporaryFolder temporary;
  const fs::path folder = temporary.path() / "fr1";
  test::MakeTumFolder(folder);
  EXPECT_TRUE(OpenDataset(folder.string(), "")->Notes().warnings.empty());
  test::WriteText(
      folder / "settings.yaml",
      "Camera.fx: 500\nCamera.fy: 500\nCamera.cx: 320\nCamera.cy: 240\nCamera.width: 640\nCamera.height: 480\n"
      "Camera.bf: 40\nDepthMapFactor: 1.0\n");
  fs::rename(folder, temporary.path() / "office");
  EXPECT_THAT(
      OpenDataset((temporary.path() / "office").string(), "")->Notes().warnings,
      ElementsAre(AllOf(HasSubstr("at 1 units a metre"), HasSubstr("1000 (millimetres) or 5000 (TUM RGB-D)"))));
}

}  // namespace
}  // namespace plslam
