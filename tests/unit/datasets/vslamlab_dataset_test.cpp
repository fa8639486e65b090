// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/vslamlab_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/datasets/camera_file.h"
#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

using test::ErrorOf;
using test::ReplaceText;
using testing::HasSubstr;

class VslamLabDataset : public testing::Test {
 protected:
  VslamLabDataset() { test::MakeVslamLabFolder(path()); }
  std::filesystem::path path() const { return folder_.path() / "sequence"; }
  std::string Error() const {
    return ErrorOf([&] { OpenVslamLabDataset(path()); });
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(VslamLabDataset, PairsRigAndTruthOfTheBody) {
  const auto dataset = OpenDataset(path(), "");
  ASSERT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->t_ns(1), 1403636584863555584);
  EXPECT_EQ(dataset->Read(2).left.at<uint8_t>(5, 7), test::TinyPixel(2, 0, 7, 5));
  EXPECT_EQ(dataset->Read(2).right.at<uint8_t>(5, 7), test::TinyPixel(2, 1, 7, 5));
  const RigCalibration& rig = dataset->rig();
  EXPECT_EQ(rig.name, "vslamlab");
  EXPECT_EQ(rig.left.model, "radtan");
  EXPECT_EQ(rig.left.fy_px, 41.0);
  EXPECT_NEAR(rig.baseline_m, 0.1, 1e-15);
  ASSERT_TRUE(dataset->GroundTruth(2));
  EXPECT_EQ(dataset->GroundTruth(2)->translation(), Eigen::Vector3d(2.0, 1.0, 1.5)) << "the camera, not the body";
}

TEST_F(VslamLabDataset, ColumnsAreFoundByTheirNames) {
  test::WriteText(path() / "rgb.csv",
                  "path_rgb_1,path_rgb_0,ts_rgb_0 (s),note\n"
                  "rgb_1/0.png,rgb_0/0.png,10.0,a\nrgb_1/1.png,rgb_0/1.png,10.1,b\n");
  const auto dataset = OpenVslamLabDataset(path());
  ASSERT_EQ(dataset->size(), 2);
  EXPECT_EQ(dataset->t_ns(1), 10'100'000'000);
  EXPECT_EQ(dataset->Read(1).right.at<uint8_t>(5, 7), test::TinyPixel(1, 1, 7, 5));
}

TEST_F(VslamLabDataset, DepthIfThereIsNoRightCamera) {
  ReplaceText(path() / "rgb.csv", "ts_rgb_1 (ns),path_rgb_1", "ts_depth_0 (ns),path_depth_0");
  EXPECT_THAT(Error(), HasSubstr("calibration.yaml:4: depth_factor"));
  ReplaceText(path() / "calibration.yaml", "cam_type: gray", "cam_type: rgb+depth, depth_factor: 1000.0");
  const auto dataset = OpenVslamLabDataset(path());
  EXPECT_EQ(dataset->rig().kind, RigCalibration::Kind::kRgbd);
  EXPECT_EQ(dataset->rig().depth_units_per_m, 1000.0);
  EXPECT_EQ(dataset->rig().baseline_m, kVirtualBaseline_m);
}

TEST_F(VslamLabDataset, LensModels) {
  const auto distortion = [&](const std::string& type, const std::string& values) {
    test::MakeVslamLabFolder(path());
    for (int camera = 0; camera < 2; ++camera) {
      ReplaceText(path() / "calibration.yaml", "radtan4", type);
      ReplaceText(path() / "calibration.yaml", "[-0.28, 0.07, 0.0002, 1.8e-05]", values);
    }
    return OpenVslamLabDataset(path())->rig().left.model;
  };
  EXPECT_EQ(distortion("equid4", "[0.01, 0.02, 0.03, 0.04]"), "equidistant");
  EXPECT_EQ(distortion("radtan5", "[0.01, 0.02, 0.03, 0.04, 0.05]"), "radtan");
  EXPECT_EQ(distortion("radtan8", "[0.1, 0.02, 0.0, 0.0, 0.05, 0.01, 0.01, 0.01]"), "rational");
  EXPECT_EQ(distortion("radtan4", "[0.0, 0.0, 0.0, 0.0]"), "pinhole");
  EXPECT_THAT(ErrorOf([&] { distortion("fov", "[0.9]"); }), HasSubstr("'fov' is not one of radtan4, radtan5"));
}

TEST_F(VslamLabDataset, MonocularAndDamagedFilesAreRefused) {
  test::WriteText(path() / "rgb.csv", "ts_rgb_0 (ns),path_rgb_0\n10,rgb_0/0.png\n");
  EXPECT_THAT(Error(), HasSubstr("rgb.csv:1: there is neither a column 'path_rgb_1' nor 'path_depth_0'"));
  test::WriteText(path() / "rgb.csv", "time,path_rgb_0\n");
  EXPECT_THAT(Error(), HasSubstr("rgb.csv:1: there is no column 'ts_rgb_0'"));
  test::WriteText(path() / "rgb.csv", "ts_rgb_0,path_rgb_0\n");
  EXPECT_THAT(Error(), HasSubstr("is neither in (ns) nor in (s)"));
  test::WriteText(path() / "rgb.csv", "");
  EXPECT_THAT(Error(), HasSubstr("rgb.csv: lists no images"));
  test::WriteText(path() / "rgb.csv", "ts_rgb_0 (ns),path_rgb_0,path_rgb_1\n10,/etc/a.png,rgb_1/0.png\n");
  EXPECT_THAT(Error(), HasSubstr("leaves the folder"));
  test::MakeVslamLabFolder(path());
  ReplaceText(path() / "calibration.yaml", "cam_name: rgb_1", "cam_name: rgb_2");
  EXPECT_THAT(Error(), HasSubstr("calibration.yaml:3: cameras has no 'rgb_1', but rgb_0, rgb_2"));
  ReplaceText(path() / "calibration.yaml", "cam_model: pinhole", "cam_model: unified");
  EXPECT_THAT(Error(), HasSubstr("'unified' is not pinhole"));
}

}  // namespace
}  // namespace plslam
