// SPDX-License-Identifier: BSD-3-Clause
// The section of docs/tutorial.md for a camera without a calibration, command by command, with rendered pictures of a
// board instead of the camera.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "core/datasets/camera_file.h"
#include "core/io/images/png_codec.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"
#include "tests/unit/calibration/board_pictures.h"
#include "tests/unit/camera/gst_elements.h"
#include "tests/unit/documents/document_commands.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kPoses = 16;
/// At 20 Hz.
constexpr int kImagesOfPose = 20;

/// A camera in front of which the board is static for a second at each of several positions.
class CalibrateRun : public testing::Test {
 protected:
  void Render(const std::string& text, int n_poses) {
    const calibration::Board board = calibration::ParseBoard(text);
    const test::CameraRays left = test::RaysOf(rig_.left), right = test::RaysOf(rig_.right);
    for (const char* side : {"left", "right"}) fs::create_directories(folder_.Path(side));
    fs::create_directories(work_);
    const std::vector<SE3> poses = test::BoardPoses(board, n_poses, 3);
    for (int i = 0; i < n_poses; ++i) {
      const SE3& T = poses[static_cast<size_t>(i)];
      const std::string first = Image("left", kImagesOfPose * i), other = Image("right", kImagesOfPose * i);
      const auto seed = static_cast<unsigned>(2 * i);
      WritePng(first, test::RenderBoard(board, left, T, 3.0, seed), 1);
      WritePng(other, test::RenderBoard(board, right, rig_.right.T_b_cam.Inverse() * T, 3.0, seed + 1), 1);
      for (int k = 1; k < kImagesOfPose; ++k) {
        fs::create_hard_link(first, Image("left", kImagesOfPose * i + k));
        fs::create_hard_link(other, Image("right", kImagesOfPose * i + k));
      }
    }
    const auto side = [&](const char* name) {
      return fmt::format(
          "multifilesrc location=\"{}/%06d.png\" caps=\"image/png,framerate=20/1\" ! pngdec ! videoconvert ! "
          "video/x-raw,format=GRAY8 ! appsink name={}",
          folder_.Path(name), name);
    };
    folder_.Write("work/rig.yaml", fmt::format("rate_hz: 20\nleft:\n  resolution_px: [640, 480]\nsource:\n"
                                               "  pipeline: '{} {}'\n",
                                               side("left"), side("right")));
  }
  std::string Image(const char* side, int i) const { return folder_.Path(fmt::format("{}/{:06}.png", side, i)); }

  test::ShellResult Run(const std::string& command) const {
    return test::Shell(
        folder_, fmt::format("cd '{}' && PATH='{}':\"$PATH\" && {}", work_, test::BinaryFolder().string(), command));
  }

  const ScratchFolder folder_;
  const std::string work_ = folder_.Path("work");
  const RigCalibration rig_ = test::KnownRig("radtan");
};

TEST_F(CalibrateRun, TheTutorialCalibratesAFakeCamera) {
  PLSLAM_REQUIRE_ELEMENTS("multifilesrc", "pngdec", "videoconvert");
  const std::string tutorial = ReadText(test::SourceFolder() / "docs" / "tutorial.md");
  const size_t begin = tutorial.find("# A camera in fifteen minutes");
  ASSERT_NE(begin, std::string::npos);
  Render("charuco:11x8:0.023:0.017", kPoses);
  int n_commands = 0;
  std::string out;
  for (const test::CommandBlock& block :
       test::CommandBlocks(tutorial.substr(begin, tutorial.find("\n# ", begin + 1)))) {
    for (const test::DocumentCommand& command : block) {
      ++n_commands;
      const test::ShellResult result = Run(command.text);
      EXPECT_EQ(result.exit_code, 0) << command.text << "\n" << result.out << result.error;
      if (command.text.find("calibrate rig.yaml") != std::string::npos) out = result.out;
    }
  }
  EXPECT_GE(n_commands, 4);
  printf("%s", out.c_str());
  EXPECT_THAT(out, HasSubstr("picture 10: "));
  EXPECT_THAT(out, HasSubstr("rectified rows of "));
  const RigCalibration read = ReadCameraFile(work_ + "/camera.yaml", {0, 0});
  // A dozen pictures are few.
  EXPECT_NEAR(read.left.fx_px / rig_.left.fx_px, 1.0, 0.003) << out;
  EXPECT_NEAR(read.baseline_m, rig_.right.T_b_cam.translation().norm(), 0.0005) << out;
  EXPECT_TRUE(NamesSource(work_ + "/camera.yaml")) << "it runs live as it is";
  EXPECT_THAT(ReadText(work_ + "/camera_coverage.html"), HasSubstr("pictures, done"));
}

TEST_F(CalibrateRun, InterruptKeepsThePicturesTaken) {
  PLSLAM_REQUIRE_ELEMENTS("multifilesrc", "pngdec", "videoconvert");
  Render("charuco:11x8:0.03:0.022", 3);
  test::ShellResult result =
      Run("{ plslam calibrate rig.yaml --board charuco:11x8:0.03:0.022 --out camera.yaml & } && "
          "for i in $(seq 200); do grep -q '^picture 1:' ../out && break; sleep 0.05; done; kill -INT $!; wait $!");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, HasSubstr("picture 1: no board near the "));
  EXPECT_THAT(result.error, HasSubstr("at least 10 are needed"));
  EXPECT_THAT(ReadText(work_ + "/camera_coverage.html"), HasSubstr("<img src=\"camera_pictures/left/001.png\">"));
  result = Run("plslam calibrate rig.yaml --board chess:9x6:0.025 --out camera.yaml");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("camera_pictures: already contains pictures"));
}

TEST_F(CalibrateRun, ACameraThatFailsKeepsThePictures) {
  PLSLAM_REQUIRE_ELEMENTS("multifilesrc", "pngdec", "videoconvert");
  Render("charuco:11x8:0.03:0.022", 3);
  test::ShellResult result =
      Run("{ plslam calibrate rig.yaml --board charuco:11x8:0.03:0.022 --out camera.yaml & } && "
          "for i in $(seq 200); do grep -q '^picture 1:' ../out && break; sleep 0.05; done; "
          "kill -KILL $(cat /proc/$!/task/*/children); wait $!");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("plslam: warning: camera was ended by SIGKILL"));
  EXPECT_THAT(result.out, HasSubstr("are kept in camera_pictures"));
  EXPECT_THAT(result.error, HasSubstr("at least 10 are needed")) << "the pictures are calibrated";
  EXPECT_THAT(ReadText(work_ + "/camera_coverage.html"), HasSubstr(", done"));
}

TEST_F(CalibrateRun, BoardOfAnotherSizeIsReported) {
  PLSLAM_REQUIRE_ELEMENTS("multifilesrc", "pngdec", "videoconvert");
  Render("charuco:11x8:0.03:0.022", 3);
  fs::create_directories(work_ + "/camera_pictures/left");
  const test::ShellResult result = Run("plslam calibrate rig.yaml --board charuco:8x11:0.03:0.022 --out camera.yaml");
  EXPECT_EQ(result.exit_code, 1) << "empty folders of a run that was killed do not matter";
  EXPECT_THAT(result.error, HasSubstr("does the board have other columns and rows?"));
}

TEST_F(CalibrateRun, MissingBoardAndCameraAreReported) {
  PLSLAM_REQUIRE_ELEMENTS("multifilesrc", "pngdec", "videoconvert");
  Render("charuco:11x8:0.03:0.022", 1);
  test::ShellResult result = Run("plslam calibrate rig.yaml --board chess:9x6:0.025 --out camera.yaml --seconds 1");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("chess:9x6:0.025 was never held still"));
  EXPECT_FALSE(fs::exists(work_ + "/camera_pictures")) << "it may be tried again";
  folder_.Write("work/other.yaml", "left:\n  resolution_px: [640, 480]\nsource:\n  pair: [/nowhere/a, /nowhere/b]\n");
  result = Run("plslam calibrate other.yaml --board chess:9x6:0.025 --out other_camera.yaml");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("source.pair: ")) << result.out;
  result = Run("plslam rectify-check other.yaml");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("check the pictures taken by `plslam calibrate other.yaml"));
}

}  // namespace
}  // namespace plslam
