// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/depth_points.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "vo_process/stereo/point_stereo.h"

namespace plslam::vo {
namespace {

const StereoCamera kDepthCamera{
    .f_px = 500.0, .cx_px = 40.0, .cy_px = 30.0, .baseline_m = 0.08, .width_px = 80, .height_px = 60};
constexpr double kUnits = 5000.0;

StereoPoint At(const cv::Mat& depth, double u, double v) {
  PointFeature feature;
  feature.px = {u, v};
  std::vector<StereoPoint> points = WithoutDepth({feature}, {});
  AttachDepthToPoints(points, depth, kUnits, kDepthCamera, {});
  return points[0];
}

cv::Mat Plane(double z_m) { return cv::Mat(60, 80, CV_16UC1, cv::Scalar(std::round(z_m * kUnits))); }

TEST(AttachDepthToPoints, PlaneGivesVirtualDisparityAndItsSigma) {
  const StereoPoint p = At(Plane(2.0), 30.4, 20.6);
  ASSERT_TRUE(p.HasDepth());
  EXPECT_NEAR(p.disparity_px, 500.0 * 0.08 / 2.0, 1e-9);
  // sigma_Z = 0.002 * 4 m; sigma_d = f b / Z^2 * sigma_Z.
  EXPECT_NEAR(p.sigma_disparity_px, 40.0 / 4.0 * 0.008, 1e-4);
}

TEST(AttachDepthToPoints, SigmaIsConstantInDisparity) {
  EXPECT_NEAR(At(Plane(1.0), 30, 20).sigma_disparity_px, At(Plane(5.0), 30, 20).sigma_disparity_px, 0.003);
}

TEST(AttachDepthToPoints, OneWildPixelIsOutvotedOnlyIfUnknown) {
  cv::Mat depth = Plane(2.0);
  depth.at<uint16_t>(20, 30) = 0;
  EXPECT_NEAR(At(depth, 30, 20).disparity_px, 20.0, 1e-9);
}

TEST(AttachDepthToPoints, BorderBetweenSurfacesHasNoDepth) {
  cv::Mat depth = Plane(2.0);
  depth(cv::Rect(0, 0, 30, 60)).setTo(std::round(3.0 * kUnits));
  EXPECT_FALSE(At(depth, 30, 20).HasDepth());
  EXPECT_TRUE(At(depth, 33, 20).HasDepth());
}

TEST(AttachDepthToPoints, TooFewKnownOutsideAndNaN) {
  cv::Mat depth(60, 80, CV_16UC1, cv::Scalar(0));
  EXPECT_FALSE(At(depth, 30, 20).HasDepth());
  depth(cv::Rect(30, 19, 1, 3)).setTo(10000);
  EXPECT_FALSE(At(depth, 30, 20).HasDepth());
  EXPECT_FALSE(At(Plane(2.0), -5, 20).HasDepth());
  EXPECT_FALSE(At(Plane(2.0), 80, 20).HasDepth());
  EXPECT_FALSE(At(Plane(2.0), std::numeric_limits<double>::quiet_NaN(), 20).HasDepth());
  EXPECT_FALSE(At(Plane(2.0), 0, 0).HasDepth()) << "four pixels are too few";
  EXPECT_TRUE(At(Plane(2.0), 0, 20).HasDepth());
}

TEST(AttachDepthToPoints, EmptyMapAndBadArguments) {
  EXPECT_FALSE(At(cv::Mat(), 30, 20).HasDepth());
  std::vector<StereoPoint> points(1);
  EXPECT_THROW(AttachDepthToPoints(points, cv::Mat(5, 5, CV_8UC1, cv::Scalar(1)), kUnits, kDepthCamera, {}),
               std::invalid_argument);
  EXPECT_THROW(AttachDepthToPoints(points, Plane(1.0), 0.0, kDepthCamera, {}), std::invalid_argument);
}

}  // namespace
}  // namespace plslam::vo
