// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/images_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/datasets/camera_file.h"
#include "core/geometry/image_mask.h"
#include "core/io/images/image_folder.h"
#include "core/io/images/png_codec.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using testing::AllOf;
using testing::HasSubstr;

class ImagesDataset : public testing::Test {
 protected:
  ImagesDataset() { test::MakeImagesFolder(folder_); }
  std::string OpenError() const {
    return ErrorOf([this] { OpenImagesDataset(folder_.string()); });
  }
  std::string At(const std::string& name) const { return (folder_ / name).string(); }

  test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "own";
  const fs::path camera_ = folder_ / "camera.yaml";
};

TEST_F(ImagesDataset, HandMadeFolder) {
  ASSERT_TRUE(LooksLikeImages(folder_.string()));
  const auto dataset = OpenImagesDataset(folder_.string());
  ASSERT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->t_ns(2), 750'000'000);
  EXPECT_EQ(dataset->rig().name, "tiny");
  EXPECT_EQ(dataset->rig().right.model, "radtan") << "the right camera is like the left one where nothing is said";
  EXPECT_DOUBLE_EQ(dataset->rig().baseline_m, 0.25);
  // left_9, left_10, left_11 in that order, with right_0009.pgm and so on.
  for (int i = 0; i < 3; ++i) {
    const StereoImages images = dataset->Read(i);
    EXPECT_EQ(images.left.at<uint8_t>(2, 1), test::TinyPixel(i, 0, 1, 2)) << i;
    EXPECT_EQ(images.right.at<uint8_t>(2, 1), test::TinyPixel(i, 1, 1, 2)) << i;
  }
  EXPECT_DOUBLE_EQ(dataset->GroundTruth(1)->translation().x(), 1.0);
  EXPECT_FALSE(dataset->GroundTruth(2)) << "0.75 s is after the last pose";
}

TEST_F(ImagesDataset, TimesFromTheRate) {
  fs::remove(folder_ / "times.txt");
  EXPECT_EQ(OpenImagesDataset(folder_.string())->t_ns(2), 200'000'000);
  test::ReplaceText(camera_, "rate_hz: 10\n", "");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("camera.yaml")), HasSubstr("rate_hz is missing")));
}

TEST_F(ImagesDataset, SparseTruthAtFrameTimesIsUsed) {
  test::WriteText(folder_ / "times.txt", "0.5004\n0.7\n0.9\n");
  test::WriteText(folder_ / "groundtruth.txt", "0.5 0 0 0 0 0 0 1\n0.7004 1 0 0 0 0 0 1\n0.8996 2 0 0 0 0 0 1\n");
  const auto dataset = OpenImagesDataset(folder_.string());
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(dataset->GroundTruth(i)) << i;
    EXPECT_DOUBLE_EQ(dataset->GroundTruth(i)->translation().x(), i);
  }
  EXPECT_TRUE(dataset->Notes().empty());
}

TEST_F(ImagesDataset, TruthOfFewFramesIsReported) {
  test::WriteText(folder_ / "groundtruth.txt", "1700000000.5 0 0 0 0 0 0 1\n1700000000.6 1 0 0 0 0 0 1\n");
  EXPECT_TRUE(OpenImagesDataset(folder_.string())->Notes().warnings.empty()) << "a warning of the run";
  EXPECT_THAT(
      OpenImagesDataset(folder_.string())->Notes().remarks,
      testing::ElementsAre("groundtruth.txt: 2 poses (1700000000.500000000 s to 1700000000.600000000 s), 0 of 3 "
                           "frames (0.500000000 s to 0.750000000 s) have one"));
  test::WriteText(folder_ / "groundtruth.txt", "# nothing yet\n");
  EXPECT_THAT(OpenImagesDataset(folder_.string())->Notes().warnings,
              testing::ElementsAre("groundtruth.txt: has no poses, so accuracy is not measured"));
  EXPECT_FALSE(OpenImagesDataset(folder_.string())->HasRecordedTruth());
}

TEST_F(ImagesDataset, PosesOfKittiFormat) {
  fs::rename(folder_ / "groundtruth.txt", folder_ / "other.txt");
  test::WriteText(folder_ / "poses.txt",
                  "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n1 0 0 0 0 1 0 0 0 0 1 2\n");
  EXPECT_DOUBLE_EQ(OpenImagesDataset(folder_.string())->GroundTruth(2)->translation().z(), 2.0);
}

TEST_F(ImagesDataset, TwoFullCameras) {
  test::WriteText(camera_, R"(rate_hz: 20
left:
  resolution_px: [48, 32]
  model: equidistant
  focal_length_px: [40, 40]
  principal_point_px: [24, 16]
  distortion: [0.1, 0, 0, 0]
  T_b_cam: [1, 0, 0, 1,  0, 1, 0, 2,  0, 0, 1, 3]
right:
  focal_length_px: [41, 41]
  principal_point_px: [24, 16]
  T_b_cam: [1, 0, 0, 1.5,  0, 1, 0, 2,  0, 0, 1, 3,  0, 0, 0, 1]
)");
  const auto dataset = OpenImagesDataset(folder_.string());
  EXPECT_DOUBLE_EQ(dataset->rig().baseline_m, 0.5);
  EXPECT_EQ(dataset->rig().left.model, "equidistant");
  EXPECT_EQ(dataset->rig().right.model, "pinhole");
}

TEST_F(ImagesDataset, ResolutionOfOneCameraIsThatOfBoth) {
  const std::string lens = "  focal_length_px: [40, 40]\n  principal_point_px: [24, 16]\n";
  const std::string size = "  resolution_px: [48, 32]\n";
  for (const std::string& text : {"baseline_m: 0.1\nleft:\n" + size + lens + "right:\n" + lens,
                                  "baseline_m: 0.1\nleft:\n" + lens + "right:\n" + size + lens}) {
    test::WriteText(camera_, text);
    const RigCalibration rig = ReadCameraFile(camera_.string(), {});
    EXPECT_EQ(rig.left.width_px, 48) << text;
    EXPECT_EQ(rig.right.height_px, 32) << text;
  }
  test::WriteText(camera_, "baseline_m: 0.1\nleft:\n" + lens + "right:\n" + lens);
  EXPECT_THAT(ErrorOf([this] { ReadCameraFile(camera_.string(), {}); }), HasSubstr("resolution_px"));
}

/// Pixels that a camera leaves out.
int LeftOut(const CameraCalibration& camera) {
  const cv::Mat mask = DrawMask(camera);
  return mask.empty() ? 0 : camera.width_px * camera.height_px - cv::countNonZero(mask);
}

TEST_F(ImagesDataset, MasksOfEachCamera) {
  cv::Mat image(test::kTinyHeight_px, test::kTinyWidth_px, CV_8UC1, cv::Scalar(1));
  image.rowRange(24, 32).setTo(0);
  WritePng(At("bonnet.png"), image);
  const std::string good = test::ReadText(camera_);
  test::WriteText(camera_, good + "  mask: bonnet.png\n");
  EXPECT_EQ(LeftOut(OpenImagesDataset(folder_.string())->rig().left), 8 * 48) << "0 is left out, all else in use";
  EXPECT_EQ(LeftOut(OpenImagesDataset(folder_.string())->rig().right), 0) << "a mask is of one camera";
  test::WriteText(
      camera_,
      good + "  mask_polygons: [[[0, 24], [47, 24], [47, 31], [0, 31]], [[0, 0], [9, 0], [9, 9], [0, 9]]]\n");
  EXPECT_EQ(LeftOut(OpenImagesDataset(folder_.string())->rig().left), 8 * 48 + 100);
  test::WriteText(camera_,
                  good + "  borders_px: [1, 2, 3, 4]\nright:\n  mask: bonnet.png\n  borders_px: [0, 1, 0, 0]\n");
  const auto dataset = OpenImagesDataset(folder_.string());
  EXPECT_EQ(LeftOut(dataset->rig().left), 48 * 32 - 44 * 26);
  EXPECT_EQ(LeftOut(dataset->rig().right), 9 * 48);
  EXPECT_EQ(dataset->rig().right.model, "radtan") << "the lens of the left camera, about which nothing else is said";
}

TEST_F(ImagesDataset, BadMasksAreNamedWithTheirLine) {
  const std::string good = test::ReadText(camera_);
  WritePng(At("small.png"), cv::Mat(16, 16, CV_8UC1, cv::Scalar(255)));
  WritePng(At("black.png"), cv::Mat(32, 48, CV_8UC1, cv::Scalar(0)));
  struct Row {
    const char* line;
    const char* key;
    const char* what;
  };
  for (const Row& row :
       {Row{"mask: none.png", "mask", "none.png"},
        Row{"mask: small.png", "mask", "small.png: has 16 x 16 pixels instead of 48 x 32"},
        Row{"mask: black.png", "mask", "no pixel is in use"}, Row{"mask: ../a.png", "mask", "leaves the folder"},
        Row{"mask: camera.yaml", "mask", "camera.yaml"}, Row{"mask: [1]", "mask", "single value"},
        Row{"mask_polygons: 3", "mask_polygons", "must be a list of polygons [[[x, y]"},
        Row{"mask_polygons: [[0, 0], [1, 0], [1, 1]]", "mask_polygons", "polygon 1 has 2 corners"},
        Row{"mask_polygons: [[[0, 0], [1, 0]]]", "mask_polygons", "polygon 1 has 2 corners, but at least 3"},
        Row{"mask_polygons: [[[0, 0], [1, 0], 3]]", "mask_polygons", "polygon 1, corner 3 is not a pair [x, y]"},
        Row{"mask_polygons: [[[0, 0], [1, nan], [1, 1]]]", "mask_polygons", "'nan' is not a finite number"},
        Row{"mask_polygons: [[[0, 0], [1, 0], [1, 1000]]]", "mask_polygons",
            "corner [1, 1000] is not within -48 to 96 and -32 to 64 pixels"},
        Row{"borders_px: [0, 0, 0]", "borders_px", "has 3 numbers, not 4"},
        Row{"borders_px: [0, 0, 0, -1]", "borders_px", "= -1 is not a whole number from 0 to 48"},
        Row{"borders_px: [24, 0, 24, 0]", "borders_px", "no pixel is in use"}}) {
    test::WriteText(camera_, good + "  " + row.line + "\n");
    EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("camera.yaml") + ":9: " + row.key), HasSubstr(row.what))) << row.line;
  }
}

TEST_F(ImagesDataset, UnpairedImageIsABadFrame) {
  fs::remove(folder_ / "right" / "right_0010.pgm");
  const auto dataset = OpenImagesDataset(folder_.string());
  ASSERT_EQ(dataset->size(), 3) << "the times stay those of the frames";
  EXPECT_THAT(ErrorOf([&] { dataset->Read(1); }), AllOf(HasSubstr(At("left/left_10.png")), HasSubstr("no partner")));
  EXPECT_EQ(dataset->Missing(0), "");
  EXPECT_EQ(dataset->Missing(1), At("left/left_10.png") + ": has no partner in " + At("right"))
      << "known without reading";
  EXPECT_EQ(dataset->Read(2).right.at<uint8_t>(0, 0), test::TinyPixel(2, 1, 0, 0));
}

TEST_F(ImagesDataset, BadCameraFilesAreNamedWithTheirLine) {
  const std::string good = test::ReadText(camera_);
  struct Row {
    const char* from;
    const char* to;
    const char* line;
    const char* what;
  };
  for (const Row& row : {Row{"[40.0, 41.0]", "[0, 41.0]", ":6: focal_length_px", "focal length fx = 0"},
                         Row{"[40.0, 41.0]", "[40.0, -1]", ":6: focal_length_px", "fy = -1"},
                         Row{"[40.0, 41.0]", "40.0", ":6: focal_length_px", "list of numbers"},
                         Row{"[24.0, 16.0]", "[1e9, 16.0]", ":7: principal_point_px", "cx = 1000000000"},
                         Row{"-0.1, 0.01,", "", ":8: distortion", "4 or 5 distortions (k1 k2 p1 p2 [k3]), not 2"},
                         Row{"-0.1, 0.01,", "nan, 0,", ":8: distortion", "'nan'"},
                         Row{"model: radtan", "model: fisheye", ":5: model",
                             "'fisheye' is not one of pinhole, radtan, rational, equidistant, double_sphere"},
                         Row{"baseline_m: 0.25", "baseline_m: -0.25", "", "to the right of the left one"},
                         Row{"baseline_m: 0.25", "baseline_m: 0", "", "baseline 0 m"},
                         Row{"baseline_m: 0.25\n", "", ":1: baseline_m", "is missing"},
                         Row{"rate_hz: 10", "rate_hz: 0", ":2: rate_hz", "above 0"},
                         Row{"rate_hz: 10", "rate: 10", ":2: rate", "is not a known key"},
                         Row{"name: tiny", "kind: rgbd", ":1: depth_units_per_m", "is missing"},
                         Row{"name: tiny", "kind: mono", ":1: kind", "'mono'"},
                         Row{"left:", "right:", ": left", "is missing"}, Row{"name: tiny", "name: [", "", ""}}) {
    test::WriteText(camera_, good);
    test::ReplaceText(camera_, row.from, row.to);
    const std::string error = OpenError();
    EXPECT_THAT(error, AllOf(HasSubstr(At("camera.yaml")), HasSubstr(row.line), HasSubstr(row.what))) << row.to;
  }
}

TEST_F(ImagesDataset, ReadoutOfARollingShutter) {
  const std::string good = test::ReadText(camera_);
  test::WriteText(camera_, good + "  readout_ms: 25\n");
  const RigCalibration rig = OpenImagesDataset(folder_.string())->rig();
  EXPECT_EQ(rig.left.readout_ms, 25.0);
  EXPECT_EQ(rig.right.readout_ms, 25.0) << "that of the left camera";
  for (const auto& [lines, line, what] : std::vector<std::array<std::string, 3>>{
           {"  readout_ms: -1\n", ":9: readout_ms", "= -1 is not within 0 (a global shutter) to 1000 ms"},
           {"  readout_ms: 101\n", ":9: readout_ms",
            "= 101 is longer than the 100 ms between frames of rate_hz = 10"},
           {"  readout_ms: 25\nright:\n  readout_ms: 12\n", ":11: readout_ms", "differs from 25"},
           {"  readout_ms: nan\n", ":9: readout_ms", "'nan'"}}) {
    test::WriteText(camera_, good + lines);
    EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("camera.yaml")), HasSubstr(line), HasSubstr(what))) << lines;
  }
}

TEST_F(ImagesDataset, ImplausibleBaselineIsQuestioned) {
  test::ReplaceText(camera_, "baseline_m: 0.25", "baseline_m: 110");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr("baseline 110 m"), HasSubstr("is it in millimetres?")));
  test::ReplaceText(camera_, "baseline_m: 110", "baseline_m: 50");
  EXPECT_THAT(OpenImagesDataset(folder_.string())->Notes().warnings,
              testing::ElementsAre(At("camera.yaml") +
                                   ": the cameras are 50 m apart: lengths must be in metres; are these?"));
  test::ReplaceText(camera_, "baseline_m: 50", "baseline_m: -0.11");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr("x = -0.11 m"), HasSubstr("T_b_cam"), HasSubstr("inverted"),
                                 HasSubstr("left and right exchanged?")));
}

TEST_F(ImagesDataset, CamerasOneAboveTheOther) {
  for (const char* y : {"0.06", "-0.06"}) {
    test::WriteText(camera_,
                    std::string("rate_hz: 10\nleft: {focal_length_px: [40, 41], principal_point_px: [24, 16]}\n"
                                "right: {T_b_cam: [1, 0, 0, 0.001, 0, 1, 0, ") +
                        y + ", 0, 0, 1, 0.002]}\n");
    const auto dataset = OpenImagesDataset(folder_.string());
    EXPECT_NEAR(dataset->rig().baseline_m, 0.06, 1e-4);
    EXPECT_TRUE(dataset->Notes().empty());
  }
}

TEST_F(ImagesDataset, TenBitsInSixteenAreStretched) {
  for (int i = 0; i < 3; ++i) {
    for (const int camera : {0, 1}) {
      cv::Mat wide(test::kTinyHeight_px, test::kTinyWidth_px, CV_16UC1);
      for (int y = 0; y < wide.rows; ++y) {
        for (int x = 0; x < wide.cols; ++x) {
          wide.at<uint16_t>(y, x) = static_cast<uint16_t>(4 * test::TinyPixel(i, camera, x, y) / (i == 0 ? 8 : 1));
        }
      }
      const std::string name = "left_" + std::to_string(9 + i) + ".png";
      WritePng((folder_ / (camera == 0 ? "left" : "right") / name).string(), wide);
    }
    fs::remove(folder_ / "right" / ("right_00" + std::string(i == 0 ? "0" : "") + std::to_string(9 + i) + ".pgm"));
  }
  const auto dataset = OpenImagesDataset(folder_.string());
  EXPECT_TRUE(dataset->Notes().warnings.empty());
  EXPECT_THAT(dataset->Notes().remarks,
              testing::ElementsAre(HasSubstr("values up to 1020, as with 10 bits: 1023 is mapped to")));
  for (int i = 0; i < 3; ++i) {
    const int part = i == 0 ? 8 : 1;
    EXPECT_NEAR(dataset->Read(i).left.at<uint8_t>(2, 1), test::TinyPixel(i, 0, 1, 2) / part, 1) << i;
    EXPECT_NEAR(dataset->Read(i).right.at<uint8_t>(2, 1), test::TinyPixel(i, 1, 1, 2) / part, 1) << i;
  }
}

TEST_F(ImagesDataset, TimesInAnotherUnitAreRefused) {
  struct Row {
    const char* times;
    const char* unit;
  };
  for (const Row& row : {Row{"0\n50\n100\n", "milliseconds"}, Row{"0\n50000\n100000\n", "microseconds"},
                         Row{"0\n50000000\n100000000\n", "nanoseconds"},
                         Row{"1700000000000\n1700000000050\n1700000000100\n", "milliseconds"},
                         Row{"1700000000000000\n1700000000050000\n1700000000100000\n", "microseconds"},
                         Row{"1700000000000000000\n1700000000050000000\n1700000000100000000\n", "nanoseconds"}}) {
    test::WriteText(folder_ / "times.txt", row.times);
    EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("times.txt")), HasSubstr(std::string(" in ") + row.unit + "?")))
        << row.times;
  }
}

TEST_F(ImagesDataset, TabInTheCameraFileIsNamed) {
  test::ReplaceText(camera_, "  model: radtan", "\tmodel: radtan");
  EXPECT_THAT(OpenError(), HasSubstr(At("camera.yaml") + ":5: is indented by a tab; YAML requires spaces"));
}

TEST_F(ImagesDataset, HostileCameraFiles) {
  test::WriteText(camera_, std::string(30000, '['));
  EXPECT_THAT(OpenError(), HasSubstr(At("camera.yaml")));
  test::WriteText(camera_, "a: &a [x, x]\nb: &b [*a, *a]\nleft: *b\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("camera.yaml")));
  test::WriteText(camera_, "- 1\n- 2\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("camera.yaml") + ":1"), HasSubstr("key: value")));
  test::WriteText(camera_, "? [a]\n: 1\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("camera.yaml")));
  test::WriteText(camera_, "name: \x01\x02\xff\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("camera.yaml")));
}

TEST_F(ImagesDataset, FoldersAndCounts) {
  test::WriteText(folder_ / "times.txt", "0.1\n0.2\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("times.txt") + ": has 2 times for 3 frames"));
  test::WriteText(folder_ / "left" / "again_0009.png", "");
  EXPECT_THAT(OpenError(), HasSubstr("has the same number as"));
  fs::remove_all(folder_ / "left");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr("none of the pairs of image folders left and right"),
                                 HasSubstr("; it has right without left")));
  fs::create_directories(folder_ / "left");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("left")), HasSubstr("no images")));
  fs::remove(camera_);
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("camera.yaml")), HasSubstr("missing")));
}

TEST(KeyOfImage, NumbersDecideTheOrder) {
  EXPECT_LT(KeyOfImage("img9.png"), KeyOfImage("img10.png"));
  EXPECT_LT(KeyOfImage("img10.png"), KeyOfImage("img0011.png"));
  EXPECT_LT(KeyOfImage("1305031102.2.png"), KeyOfImage("1305031102.275.png"));
  EXPECT_LT(KeyOfImage("1305031102.275.png"), KeyOfImage("1305031103.1.png"));
  EXPECT_LT(KeyOfImage("99.png"), KeyOfImage("last.png"));
  EXPECT_EQ(KeyOfImage("left_0012.png").whole, "12");
  EXPECT_EQ(KeyOfImage("left_0012_rect.png").whole, "12");
  EXPECT_EQ(KeyOfImage("cam0_000.png").whole, "0");
  EXPECT_EQ(KeyOfImage("v1.2.3.png").whole, "3");
}

}  // namespace
}  // namespace plslam
