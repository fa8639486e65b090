// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/datasets/foreign_calibration_fixture.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using test::ExpectTheRig;
using testing::AllOf;
using testing::HasSubstr;

class CameraInfoFile : public test::ForeignCalibrationTest {};

TEST_F(CameraInfoFile, OrderOfRosFilesDoesNotMatter) {
  const std::vector<std::string> paths = WriteAll(RigCalled("left.yaml"));
  ExpectTheRig(ReadForeignCalibration({paths[1], paths[0]}, kSize).rig, "right, left");
}

TEST_F(CameraInfoFile, ProjectionsOfNoRectifiedPair) {
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

  // A converter of KITTI's colour cameras writes this: both are beside the first grey camera, not quite level.
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

TEST_F(CameraInfoFile, CameraInfoOfBinnedImagesAndOfAPart) {
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
              HasSubstr("for 672 x 376 pixels (336 x 188 with its binning and region of interest), but the images "
                        "have 320 x 240"));
  EXPECT_THAT(ErrorOf([&] { read("roi: {x_offset: 400, y_offset: 0, height: 200, width: 400}\n", {}); }),
              HasSubstr("is not within its 672 x 376 pixels"));
}

TEST_F(CameraInfoFile, CameraInfoWithoutDistortion) {
  const auto& ros = RigCalled("left.yaml").files;
  const std::string none =
      Replaced(Replaced(ros[0].text, "cols: 5", "cols: 0"), "[-0.28, 0.07, 0.0002, -0.0001, 0]", "[]");
  const std::vector<std::string> paths{Write("left.yaml", Replaced(none, "distortion_model: plumb_bob\n", "")),
                                       Write("right.yaml", ros[1].text)};
  EXPECT_EQ(ReadForeignCalibration(paths, kSize).rig.left.model, "pinhole");
}

}  // namespace
}  // namespace plslam
