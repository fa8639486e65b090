// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/features_in_camera.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plslam {
namespace {

const StereoCamera kWide{180.0, 187.5, 119.5, 0.06, 376, 240};
const StereoCamera kLong{460.0, 367.2, 248.4, 0.12, 752, 480};

StereoPoint PointAt(const Eigen::Vector3d& p_c, int octave, const StereoCamera& camera) {
  const Eigen::Vector3d uvd = camera.ProjectStereo(p_c);
  StereoPoint point;
  point.left.px = uvd.head<2>();
  point.left.octave = octave;
  point.disparity_px = uvd.z();
  point.sigma_px = 0.5;
  point.sigma_disparity_px = 0.3;
  return point;
}

StereoFeatures SeenBy(const StereoCamera& camera) {
  StereoFeatures features;
  features.points = {PointAt({0.3, -0.2, 2.0}, 1, camera), PointAt({-4.0, 1.0, 9.0}, 5, camera)};
  features.points.push_back(features.points[0]);
  features.points[2].disparity_px = -1.0;
  StereoLine line;
  line.left.segment = {camera.Project({-1.0, 0.5, 3.0}), camera.Project({1.0, 0.4, 5.0})};
  line.disparity_p_px = camera.FocalBaseline() / 3.0;
  line.disparity_q_px = camera.FocalBaseline() / 5.0;
  features.lines = {line};
  return features;
}

TEST(FeaturesInCamera, RaysAndDepthsArePreserved) {
  const StereoFeatures moved = FeaturesInCamera(kLong, SeenBy(kWide), kWide);
  const StereoFeatures there = SeenBy(kLong);
  for (size_t i = 0; i < moved.points.size(); ++i) {
    EXPECT_LT((moved.points[i].left.px - there.points[i].left.px).norm(), 1e-4) << i;
    EXPECT_EQ(moved.points[i].HasDepth(), there.points[i].HasDepth()) << i;
    if (there.points[i].HasDepth()) {
      EXPECT_NEAR(moved.points[i].disparity_px, there.points[i].disparity_px, 1e-4) << i;
    }
  }
  const StereoLine& line = moved.lines[0];
  EXPECT_LT((line.left.segment.p - there.lines[0].left.segment.p).norm(), 1e-4);
  EXPECT_LT((line.left.segment.q - there.lines[0].left.segment.q).norm(), 1e-4);
  EXPECT_NEAR(line.disparity_p_px, there.lines[0].disparity_p_px, 1e-4);
  EXPECT_NEAR(line.disparity_q_px, there.lines[0].disparity_q_px, 1e-4);
}

TEST(FeaturesInCamera, StandardDeviationsInMetresArePreserved) {
  const Eigen::Vector3d p_c(0.3, -0.2, 2.0);
  const StereoPoint seen = SeenBy(kWide).points[0];
  const StereoPoint moved = FeaturesInCamera(kLong, SeenBy(kWide), kWide).points[0];
  const auto covariance = [&p_c](const StereoCamera& camera, const StereoPoint& point) {
    return camera.BackprojectCovariance(camera.ProjectStereo(p_c), point.sigma_px, point.sigma_disparity_px);
  };
  const Eigen::Matrix3d own = covariance(kWide, seen);
  EXPECT_LT((covariance(kLong, moved) - own).norm(), 1e-6 * own.norm());
}

TEST(FeaturesInCamera, KeepsOctavesAndScalesThem) {
  const StereoFeatures moved = FeaturesInCamera(kLong, SeenBy(kWide), kWide);
  EXPECT_EQ(moved.points[1].left.octave, 5);
  EXPECT_EQ(CameraOf(moved, kLong).OctaveScale(), 460.0 / 180.0);
  EXPECT_EQ(CameraOf(SeenBy(kLong), kLong).OctaveScale(), 1.0);
}

TEST(FeaturesInCamera, RejectsTooDifferentCameras) {
  EXPECT_TRUE(AreComparable(kLong, kWide));
  StereoCamera other = kWide;
  other.f_px = 1.0;
  EXPECT_FALSE(AreComparable(kWide, other));
  other = kWide;
  other.baseline_m = 7.0;
  EXPECT_FALSE(AreComparable(other, kWide));
}

TEST(FeaturesInCamera, ImageIsStoredWithTheFeatures) {
  const StereoFeatures moved = FeaturesInCamera(kLong, SeenBy(kWide), kWide);
  ASSERT_TRUE(moved.image);
  const StereoCamera looked = CameraOf(moved, kLong);
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(374.0, 238.0)}) {
    const Eigen::Vector3d ray((corner.x() - kWide.cx_px) / kWide.f_px, (corner.y() - kWide.cy_px) / kWide.f_px, 1.0);
    EXPECT_TRUE(looked.InImage(kLong.Project(ray), 0.0)) << corner.transpose();
  }
  EXPECT_FALSE(looked.InImage({looked.left_px - 1.0, 100.0}, 0.0));
  EXPECT_FALSE(looked.InImage({looked.left_px + looked.width_px + 0.0, 100.0}, 0.0));
}

TEST(FeaturesInCamera, EqualCamerasKeepEveryBit) {
  const StereoFeatures seen = SeenBy(kWide);
  const StereoFeatures moved = FeaturesInCamera(kWide, seen, kWide);
  EXPECT_FALSE(moved.image);
  for (size_t i = 0; i < seen.points.size(); ++i) {
    EXPECT_EQ(moved.points[i].left.px, seen.points[i].left.px);
    EXPECT_EQ(moved.points[i].disparity_px, seen.points[i].disparity_px);
    EXPECT_EQ(moved.points[i].left.octave, seen.points[i].left.octave);
  }
  EXPECT_EQ(moved.lines[0].left.segment.p, seen.lines[0].left.segment.p);
}

// A restarted mapping_process publishes keyframes in the camera of the map.
TEST(FeaturesInCamera, RepeatedConversionKeepsTheBits) {
  const StereoFeatures moved = FeaturesInCamera(kLong, SeenBy(kWide), kWide);
  const StereoFeatures again = FeaturesInCamera(kLong, moved, CameraOf(moved, kLong));
  EXPECT_EQ(again.image, moved.image);
  for (size_t i = 0; i < moved.points.size(); ++i) {
    EXPECT_EQ(again.points[i].left.px, moved.points[i].left.px);
    EXPECT_EQ(again.points[i].left.px.x(), static_cast<float>(moved.points[i].left.px.x())) << "as in messages";
    EXPECT_EQ(again.points[i].sigma_disparity_px, static_cast<float>(moved.points[i].sigma_disparity_px));
  }
}

}  // namespace
}  // namespace plslam
