// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/tools/body_motion.h"
#include "tests/tools/body_picture.h"
#include "tests/tools/body_texture.h"

namespace plslam::test {
namespace {

constexpr StereoCamera kCamera{300.0, 159.5, 99.5, 0.5, 320, 200};

// A camera that drives straight ahead at 1 m a frame.
std::vector<SE3> Straight(int frames) {
  std::vector<SE3> path;
  for (int i = 0; i < frames; ++i) path.emplace_back(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, 0.0, i));
  return path;
}

// The rear of a body has one depth: the right picture is the left one, shifted by its disparity.
TEST(PasteBodies, RightPictureIsShiftedByTheDisparity) {
  const Body body = MakeBox({3.0, 2.0, 1.0}, {PaintVehicle(1)});
  for (const int disparity : {15, 25, 37}) {
    const double depth = kCamera.Depth(disparity);
    const SE3 T_b_c(Eigen::Quaterniond::Identity(), {-0.3, 0.1, -depth - 0.5});
    const SE3 T_c_r(Eigen::Quaterniond::Identity(), {kCamera.baseline_m, 0.0, 0.0});
    const BodyPicture left = PictureOfBody(body, kCamera, T_b_c);
    const BodyPicture right = PictureOfBody(body, kCamera, T_b_c * T_c_r);
    int n = 0;
    for (int y = 0; y < kCamera.height_px; ++y) {
      for (int x = disparity; x < kCamera.width_px; ++x) {
        if (left.coverage.at<float>(y, x) < 1.0F || right.coverage.at<float>(y, x - disparity) < 1.0F) continue;
        ASSERT_NEAR(left.value.at<float>(y, x), right.value.at<float>(y, x - disparity), 0.1) << depth;
        ++n;
      }
    }
    EXPECT_GT(n, 1000) << depth;
  }
}

TEST(PasteBodies, OutlineMatchesTheProjectedCorners) {
  const Body body = MakeBox({2.0, 1.0, 1.0}, {PaintVehicle(2)});
  const SE3 T_b_c(Eigen::Quaterniond::Identity(), {0.2, 0.1, -6.0});
  const BodyPicture picture = PictureOfBody(body, kCamera, T_b_c);
  double columns = 0.0;
  for (int x = 0; x < kCamera.width_px; ++x) columns += picture.coverage.at<float>(90, x);
  EXPECT_NEAR(columns, 2.0 / 5.5 * kCamera.f_px, 0.1);
  EXPECT_EQ(picture.coverage.at<float>(0, 0), 0.0F);
}

TEST(PasteBodies, EveryKindEntersTheViewAndCoversItsShare) {
  const std::vector<SE3> path = Straight(60);
  for (const std::string& kind : BodyKindNames()) {
    const MovingBox box = MoveBody({kind, 0.5, 0.0, 3}, kCamera, path);
    ASSERT_EQ(box.T_w_b.size(), path.size());
    const Body body = MakeBox(box.size_m, {PaintVehicle(3)});
    double most = 0.0;
    for (size_t i = 0; i < path.size(); i += 3) {
      const cv::Mat coverage = PictureOfBody(body, kCamera, box.T_w_b[i].Inverse() * path[i]).coverage;
      cv::Mat columns;
      cv::reduce(coverage, columns, 0, cv::REDUCE_MAX);
      most = std::max(most, cv::sum(columns)[0] / kCamera.width_px);
    }
    EXPECT_GT(most, 0.25) << kind;
    EXPECT_LT(most, 0.8) << kind;
  }
}

TEST(PasteBodies, PastingLeavesTheRestAlone) {
  const Body body = MakeBox({2.0, 1.0, 1.0}, {PaintVehicle(2)});
  const BodyPicture picture = PictureOfBody(body, kCamera, SE3(Eigen::Quaterniond::Identity(), {0.0, 0.0, -6.0}));
  cv::Mat image(kCamera.height_px, kCamera.width_px, CV_8U, cv::Scalar(77));
  Paste(picture, 1.5, 1, &image);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (picture.coverage.at<float>(y, x) == 0.0F) {
        ASSERT_EQ(image.at<uint8_t>(y, x), 77);
      }
    }
  }
  EXPECT_GT(cv::countNonZero(image != 77), 1000);
}

}  // namespace
}  // namespace plslam::test
