// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/datasets/camera_file.h"
#include "core/io/images/png_codec.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tests/unit/calibration/board_pictures.h"

namespace plslam::calibration {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CalibrateProgram : public testing::Test {
 protected:
  CalibrateProgram() {
    std::string pattern = testing::TempDir() + "calibrate XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  ~CalibrateProgram() override { fs::remove_all(folder_); }

  int Run(const std::string& arguments, const std::string& command_name = "calibrate") {
    const std::string command = "cd '" + folder_.string() + "' && '" + (test::BinaryFolder() / "plslam").string() +
                                "' " + command_name + " " + arguments + " >out 2>error";
    return WEXITSTATUS(std::system(command.c_str()));  // NOLINT: the test runs the program
  }
  std::string Text(const std::string& name) const { return ReadText(folder_ / name); }

  void Render(const Board& board, const RigCalibration& rig, int n) {
    fs::create_directories(folder_ / "pictures" / "left");
    fs::create_directories(folder_ / "pictures" / "right");
    const std::vector<SE3> poses = test::BoardPoses(board, n, 3);
    const test::CameraRays left = test::RaysOf(rig.left), right = test::RaysOf(rig.right);
    for (size_t i = 0; i < poses.size(); ++i) {
      const std::string name = fmt::format("{:03}.png", i);
      const auto seed = static_cast<unsigned>(2 * i);
      WritePng((folder_ / "pictures" / "left" / name).string(), test::RenderBoard(board, left, poses[i], 3.0, seed));
      WritePng((folder_ / "pictures" / "right" / name).string(),
               test::RenderBoard(board, right, rig.right.T_b_cam.Inverse() * poses[i], 3.0, seed + 1));
    }
  }
  void KeepPictures(size_t n) {
    for (const char* side : {"left", "right"}) {
      for (size_t i = n; fs::remove(folder_ / "pictures" / side / fmt::format("{:03}.png", i)); ++i) continue;
    }
  }
  fs::path folder_;
};

TEST_F(CalibrateProgram, RenderedPicturesGiveTheRig) {
  const RigCalibration rig = test::KnownRig("radtan");
  Render(ParseBoard("charuco:11x8:0.03:0.022"), rig, 60);
  ASSERT_EQ(Run("pictures --board charuco:11x8:0.03:0.022 --out camera.yaml"), 0) << Text("error");
  const std::string out = Text("out");
  EXPECT_THAT(out, HasSubstr("reprojection error 0."));
  EXPECT_THAT(out, HasSubstr("baseline"));
  const RigCalibration read = ReadCameraFile((folder_ / "camera.yaml").string(), {0, 0});
  EXPECT_NEAR(read.left.fx_px / rig.left.fx_px, 1.0, 0.0005) << out;
  EXPECT_NEAR(read.left.fy_px / rig.left.fy_px, 1.0, 0.0005);
  EXPECT_NEAR(read.right.fx_px / rig.right.fx_px, 1.0, 0.0005);
  EXPECT_NEAR(read.right.fy_px / rig.right.fy_px, 1.0, 0.0005);
  EXPECT_NEAR(read.baseline_m, rig.right.T_b_cam.translation().norm(), 0.0001) << out;
  printf("%s", out.c_str());

  // A fifth of the pictures shows a wrong board, too.
  KeepPictures(12);
  EXPECT_EQ(Run("pictures --board charuco:10x8:0.03:0.022"), 1) << Text("out");
  EXPECT_THAT(Text("error"), HasSubstr("does the board have other columns and rows?"));
  EXPECT_EQ(Run("pictures --board charuco:11x7:0.03:0.022"), 1) << Text("out");
  EXPECT_THAT(Text("error"), HasSubstr("does the board have other columns and rows?"));
  EXPECT_EQ(Run("pictures --board charuco:11x9:0.03:0.022 --out other.yaml"), 1) << Text("out");
  EXPECT_THAT(Text("error"), HasSubstr("row of the board charuco:11x9:0.03:0.022: does the board have fewer"));
  EXPECT_FALSE(fs::exists(folder_ / "other.yaml"));
  fs::rename(folder_ / "pictures" / "left", folder_ / "pictures" / "other");
  fs::rename(folder_ / "pictures" / "right", folder_ / "pictures" / "left");
  fs::rename(folder_ / "pictures" / "other", folder_ / "pictures" / "right");
  EXPECT_EQ(Run("pictures --board charuco:11x8:0.03:0.022"), 1);
  EXPECT_THAT(Text("error"), HasSubstr("exchanged"));
}

TEST_F(CalibrateProgram, AprilgridOfKalibr) {
  const RigCalibration rig = test::KnownRig("radtan");
  const std::string board = "aprilgrid:6x4:0.04:0.3";
  Render(ParseBoard(board), rig, 16);
  ASSERT_EQ(Run("pictures --board " + board + " --out camera.yaml --print-board board.pdf"), 0) << Text("error");
  const std::string out = Text("out");
  const RigCalibration read = ReadCameraFile((folder_ / "camera.yaml").string(), {0, 0});
  // Tolerances for so few pictures.
  EXPECT_NEAR(read.left.fx_px / rig.left.fx_px, 1.0, 0.003) << out;
  EXPECT_NEAR(read.right.fy_px / rig.right.fy_px, 1.0, 0.003) << out;
  EXPECT_NEAR(read.baseline_m, rig.right.T_b_cam.translation().norm(), 0.0003) << out;
  EXPECT_THAT(out, HasSubstr("rectified rows of "));
  EXPECT_THAT(Text("board.pdf"), HasSubstr("tags of 40 mm"));
  printf("%s", out.c_str());
  EXPECT_EQ(Run("pictures --board aprilgrid:5x4:0.04:0.3"), 1) << Text("out");
  EXPECT_THAT(Text("error"), HasSubstr("does the board have other columns and rows?"));
  EXPECT_EQ(Run("pictures --board aprilgrid:6x5:0.04:0.3"), 1) << Text("out");
  EXPECT_THAT(Text("error"), HasSubstr("uppermost row of the board aprilgrid:6x5:0.04:0.3"));
}

TEST_F(CalibrateProgram, AChessBoardOfAnotherSize) {
  Render(ParseBoard("chess:9x6:0.025"), test::KnownRig("radtan"), 1);
  EXPECT_EQ(Run("pictures --board chess:9x6:0.025"), 1);
  EXPECT_THAT(Text("error"), HasSubstr("at least 10 are needed"));
  EXPECT_EQ(Run("pictures --board chess:10x7:0.025"), 1);
  EXPECT_THAT(Text("error"), HasSubstr("chess:9x6:0.025 is seen in one"));
  EXPECT_EQ(Run("nowhere --board chess:10x7:0.025"), 1);
  EXPECT_THAT(Text("error"), HasSubstr("nowhere"));
}

TEST_F(CalibrateProgram, UnusableRigFilesAreNamed) {
  const auto write = [&](const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; };
  const std::string left = "left:\n  resolution_px: [640, 480]\n", board = " --board chess:9x6:0.025";
  write("nosrc.yaml", left);
  EXPECT_EQ(Run("nosrc.yaml --out camera.yaml" + board), 1);
  EXPECT_THAT(Text("error"), HasSubstr("nosrc.yaml:1: source is missing"));
  EXPECT_EQ(Run("none.yaml --out camera.yaml" + board), 1);
  EXPECT_THAT(Text("error"), HasSubstr("none.yaml: the calibration cannot be read"));
  write("rig.yaml", left + "source:\n  pair: [/nowhere/a, /nowhere/b]\n");
  EXPECT_EQ(Run("rig.yaml --out ./rig.yaml" + board), 1);
  EXPECT_THAT(Text("error"), HasSubstr("is the rig file itself"));
  EXPECT_EQ(Run("rig.yaml" + board), 1);
  EXPECT_THAT(Text("error"), HasSubstr("add --out camera.yaml"));
  EXPECT_EQ(Run("pictures --seconds 3" + board), 1);
  EXPECT_THAT(Text("error"), HasSubstr("--seconds is for a rig file only"));
}

TEST_F(CalibrateProgram, PrintsABoard) {
  ASSERT_EQ(Run("--board charuco:11x8:0.023:0.017 --print-board board.pdf"), 0) << Text("error");
  EXPECT_THAT(Text("board.pdf"), testing::StartsWith("%PDF-1.4\n"));
  EXPECT_THAT(Text("out"), HasSubstr("print at 100 % (no fit to page) on A4 or Letter paper"));
  ASSERT_EQ(Run("--board charuco:11x8:0.03:0.022 --print-board large.pdf"), 0) << Text("error");
  EXPECT_THAT(Text("out"), HasSubstr("on A3 or Tabloid paper"));
  EXPECT_EQ(Run("--board charuco:11x8:0.03:0.022"), 1);
  EXPECT_THAT(Text("error"), HasSubstr("--print-board"));
}

TEST_F(CalibrateProgram, CalibrationAsksForTheUnitOfLengths) {
  std::ofstream(folder_ / "stereo.yml") << "image_width: 640\nimage_height: 480\n"
                                           "M1: [530, 0, 320, 0, 530, 240, 0, 0, 1]\nD1: [0, 0, 0, 0]\n"
                                           "M2: [530, 0, 320, 0, 530, 240, 0, 0, 1]\nD2: [0, 0, 0, 0]\n"
                                           "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [-60, 0, 0]\n";
  EXPECT_EQ(Run("stereo.yml --out camera.yaml", "calibration"), 1);
  EXPECT_THAT(Text("error"),
              HasSubstr("the cameras are 60 m apart: state the unit of its lengths, --unit m, cm or mm"));
  EXPECT_FALSE(fs::exists(folder_ / "camera.yaml"));
  EXPECT_EQ(Run("stereo.yml --unit mm --out camera.yaml", "calibration"), 0) << Text("error");
  EXPECT_THAT(Text("out"), HasSubstr("baseline 0.06000 m"));
  EXPECT_DOUBLE_EQ(ReadCameraFile((folder_ / "camera.yaml").string(), {0, 0}).baseline_m, 0.06);
  EXPECT_EQ(Run("stereo.yml --unit m --out camera.yaml", "calibration"), 0) << Text("error");
  EXPECT_NE(Run("stereo.yml --unit inch", "calibration"), 0);
}

}  // namespace
}  // namespace plslam::calibration
