#include "vo_process/stereo/stereo_front_end.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

RigCalibration Rig(int width, int height) {
  RigCalibration rig;
  rig.left.width_px = rig.right.width_px = width;
  rig.left.height_px = rig.right.height_px = height;
  rig.left.fx_px = rig.left.fy_px = rig.right.fx_px = rig.right.fy_px = 200.0;
  rig.left.cx_px = rig.right.cx_px = 0.5 * width;
  rig.left.cy_px = rig.right.cy_px = 0.5 * height;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  rig.baseline_m = 0.1;
  return rig;
}

StereoImages Uniform(int width, int height, int grey) {
  StereoImages images;
  images.left = cv::Mat(height, width, CV_8UC1, cv::Scalar(grey));
  images.right = images.left.clone();
  return images;
}

TEST(StereoFrontEnd, BlackAndOverexposedImagesHaveNoFeatures) {
  StereoFrontEnd front_end(Rig(320, 240), VoOptions());
  for (const int grey : {0, 128, 255}) {
    StageTimer timer;
    const StereoFeatures features = front_end.Process(Uniform(320, 240, grey), timer);
    EXPECT_EQ(features.points.size() + features.lines.size(), 0U) << "grey " << grey;
  }
}

TEST(StereoFrontEnd, ImagesOfAnotherSizeAreRefusedWithBothSizes) {
  StereoFrontEnd front_end(Rig(320, 240), VoOptions());
  StageTimer timer;
  try {
    front_end.Process(Uniform(300, 240, 0), timer);
    FAIL() << "accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("300"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("320"), std::string::npos) << error.what();
  }
}

TEST(StereoFrontEnd, StagesAreTimedByTheGivenClock) {
  StereoFrontEnd front_end(Rig(320, 240), VoOptions());
  double now = 0.0;
  StageTimer timer([&now] { return now += 1.0; });
  front_end.Process(Uniform(320, 240, 0), timer);
  ASSERT_EQ(timer.stages().size(), 2U);
  EXPECT_EQ(timer.stages()[0].name, "features");
  EXPECT_EQ(timer.stages()[1].name, "stereo");
  EXPECT_DOUBLE_EQ(timer.stages()[0].ms, 1.0);
}

}  // namespace
}  // namespace plslam
