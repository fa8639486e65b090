// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/live/picture_taker.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "core/files/dataset_error.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tests/unit/calibration/board_pictures.h"
#include "tools/calibration/live/coverage_page.h"
#include "tools/calibration/live/live_rig.h"

namespace plslam::calibration {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr ImageSize kSize{640, 480};

/// Shows boards at 10 Hz to a taker.
class LiveBoard : public testing::Test {
 protected:
  bool Look(const SE3& T_left_board) {
    t_s_ += 0.1;
    ++looks_;
    const SE3 T_right_board = rig_.right.T_b_cam.Inverse() * T_left_board;
    return taker_.Add(test::SeenBoard(board_, rig_.left, T_left_board, 0.1, 2 * looks_),
                      test::SeenBoard(board_, rig_.right, T_right_board, 0.1, 2 * looks_ + 1), t_s_);
  }
  int LookLong(const SE3& T_left_board) {
    int taken = 0;
    for (int i = 0; i < 8; ++i) taken += Look(T_left_board) ? 1 : 0;
    return taken;
  }

  Board board_ = ParseBoard("charuco:11x8:0.03:0.022");
  RigCalibration rig_ = test::KnownRig("radtan");
  PictureTaker taker_{board_, kSize};
  double t_s_ = 0.0;
  unsigned looks_ = 0;
};

TEST_F(LiveBoard, OnePicturePerPlaceWhereItStandsStill) {
  const SE3 T = test::BoardPoses(board_, 1, 5).front();
  for (int i = 0; i < 30; ++i) {
    const SE3 moved(T.rotation(), T.translation() + Eigen::Vector3d(0.004 * i, 0.0, 0.0));
    EXPECT_FALSE(Look(moved)) << "5 px a look at least";
  }
  EXPECT_EQ(LookLong(T), 1);
  EXPECT_EQ(LookLong(T), 0);
  EXPECT_EQ(taker_.pictures(), 1);
}

TEST_F(LiveBoard, ABoardThatIsNotMovedIsOnePlace) {
  for (const SE3& T : test::BoardPoses(board_, 20, 11)) {
    int taken = 0;
    for (int i = 0; i < 100; ++i) taken += Look(T) ? 1 : 0;
    EXPECT_LE(taken, 1);
  }
  EXPECT_GE(taker_.pictures(), 5);
}

TEST_F(LiveBoard, MissingViewsAreReportedUntilComplete) {
  EXPECT_THAT(taker_.Missing(), Contains("no board near the upper right corner of the left image"));
  int shown = 0;
  for (const SE3& T : test::BoardPoses(board_, 150, 6)) {
    if (taker_.Missing().empty()) break;
    LookLong(T);
    ++shown;
  }
  EXPECT_THAT(taker_.Missing(), testing::IsEmpty()) << testing::PrintToString(taker_.Missing());
  EXPECT_LT(taker_.pictures(), 80);
  printf("complete with %d pictures of %d places\n", taker_.pictures(), shown);
}

TEST_F(LiveBoard, BoardsThatAreNotTiltedAreNotEnough) {
  for (const SE3& T : test::BoardPoses(board_, 40, 7)) {
    const Eigen::Vector3d middle = T * Eigen::Vector3d(0.5 * board_.width_m(), 0.5 * board_.height_m(), 0.0);
    const Eigen::Vector3d corner = middle - Eigen::Vector3d(0.5 * board_.width_m(), 0.5 * board_.height_m(), 0.0);
    LookLong(SE3(Eigen::Quaterniond::Identity(), corner));
  }
  EXPECT_GE(taker_.pictures(), 5);
  EXPECT_THAT(taker_.Missing(), Contains("no board turned to the left by 20 degrees"));
}

TEST_F(LiveBoard, PageShowsPicturesAndReloadsWhileItRuns) {
  LookLong(test::BoardPoses(board_, 1, 5).front());
  const std::string page = CoveragePage(taker_, {"camera_pictures/left/001.png"}, true);
  EXPECT_THAT(page, HasSubstr("http-equiv=\"refresh\""));
  EXPECT_THAT(page, HasSubstr("<h1>1 picture</h1>"));
  EXPECT_THAT(page, HasSubstr("<img src=\"camera_pictures/left/001.png\">"));
  EXPECT_THAT(page, HasSubstr("more pictures, each at another position"));
  EXPECT_THAT(CoveragePage(taker_, {}, false), Not(HasSubstr("refresh")));
}

TEST(LiveRigFile, NeedsNoLens) {
  const ScratchFolder folder;
  const LiveRigFile rig = ReadLiveRigFile(folder.Write(
      "rig.yaml", "rate_hz: 20\nleft:\n  resolution_px: [640, 480]\nsource:\n  files: [a.mp4, b.mp4]\n"));
  EXPECT_EQ(rig.size, kSize);
  EXPECT_THAT(rig.source, HasSubstr(folder.Path("a.mp4")));
  EXPECT_THAT(rig.for_camera, HasSubstr("focal_length_px: [640, 640]"));
  const LiveRigFile again = ReadLiveRigFile(folder.Write("again.yaml", rig.for_camera));
  EXPECT_EQ(again.source, rig.source);
  EXPECT_EQ(again.rate_hz, 20.0);
}

TEST(LiveRigFile, ExampleRigsCanBeCalibrated) {
  for (const auto& entry : std::filesystem::directory_iterator(test::SourceFolder() / "config" / "rigs")) {
    const LiveRigFile rig = ReadLiveRigFile(entry.path().string());
    EXPECT_EQ(rig.name, entry.path().stem().string());
    EXPECT_GT(rig.rate_hz, 0.0) << entry.path();
  }
}

TEST(LiveRigFile, NameAndPoseOfTheLeftCameraAreKept) {
  const ScratchFolder folder;
  const LiveRigFile rig = ReadLiveRigFile(
      folder.Write("rig.yaml",
                   "name: front\nleft:\n  resolution_px: [640, 480]\n  T_b_cam: [0, 0, 1, 0.2, -1, 0, 0, 0.1, 0, -1, "
                   "0, 0.3]\nsource:\n  pair: [a, b]\n"));
  EXPECT_EQ(rig.name, "front");
  EXPECT_EQ(rig.T_b_left.translation(), Eigen::Vector3d(0.2, 0.1, 0.3));
  EXPECT_THAT(rig.for_camera, HasSubstr("name: \"front\""));
}

TEST(LiveRigFile, ErrorsNameFileLineAndKey) {
  const ScratchFolder folder;
  const std::string left = "left:\n  resolution_px: [640, 480]\n", source = "source:\n  pair: [a, b]\n";
  const std::pair<std::string, const char*> cases[] = {
      {"left: {}\n" + source, "rig.yaml:1: resolution_px is missing"},
      {left, "rig.yaml:1: source is missing"},
      {left + "source:\n  pair: [a]\n", "rig.yaml:4: pair has 1 entries"},
      {left + "  borders_px: [0, 0, 0, 80]\n" + source, "rig.yaml:3: borders_px is not copied"},
      {left + "  mask: mask.png\n" + source, "rig.yaml:3: mask is not copied"},
      {left + source + "rat_hz: 20\n", "rig.yaml:5: rat_hz is not a known key"},
      {left + source + "rate_hz: -1\n", "rig.yaml:5: rate_hz = -1 is not above 0"},
      {"left:\n  resolution_px: [640, 4.5]\n" + source, "rig.yaml:2: resolution_px 4.5 is not a whole number"},
      {left + "right:\n  resolution_px: [320, 240]\n" + source, "rig.yaml:4: resolution_px differs"},
      {"left: [\n", "rig.yaml:"},
  };
  for (const auto& [text, complaint] : cases) {
    try {
      ReadLiveRigFile(folder.Write("rig.yaml", text));
      ADD_FAILURE() << text;
    } catch (const DatasetError& error) {
      EXPECT_THAT(error.what(), HasSubstr(complaint)) << text;
    }
  }
}

}  // namespace
}  // namespace plslam::calibration
