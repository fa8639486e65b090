// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/static_frames.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

const Eigen::Quaterniond kOptical(0.5, -0.5, 0.5, -0.5);

TEST(StaticFrames, CameraAtTheEndOfAChain) {
  StaticFrames frames;
  frames.Add("camera_link", "left_optical", SE3(kOptical, {0.0, 0.05, 0.0}));
  EXPECT_FALSE(frames.Find("base_link", "left_optical"));
  frames.Add("base_link", "camera_link", SE3(Eigen::Quaterniond::Identity(), {0.3, 0.0, 0.2}));
  const auto T = frames.Find("base_link", "left_optical");
  ASSERT_TRUE(T);
  EXPECT_LT((T->translation() - Eigen::Vector3d(0.3, 0.05, 0.2)).norm(), 1e-12);
  // The camera looks along x of the body.
  EXPECT_LT((T->rotation() * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_TRUE(frames.Find("left_optical", "left_optical"));
}

TEST(StaticFrames, SensorsOfOneBody) {
  StaticFrames frames;
  frames.Add("base_link", "camera_link", SE3(Eigen::Quaterniond::Identity(), {0.3, 0.0, 0.2}));
  frames.Add("camera_link", "left_optical", SE3(kOptical, {0.0, 0.05, 0.0}));
  frames.Add("camera_link", "imu", SE3(Eigen::Quaterniond::Identity(), {0.0, 0.02, 0.01}));
  const auto T_left_imu = frames.Between("left_optical", "imu");
  ASSERT_TRUE(T_left_imu);
  // The sensor is 3 cm to the right of the camera, and 1 cm above it.
  EXPECT_LT((T_left_imu->translation() - Eigen::Vector3d(0.03, -0.01, 0.0)).norm(), 1e-12);
  EXPECT_LT((T_left_imu->rotation() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  const auto T_imu_left = frames.Between("imu", "left_optical");
  ASSERT_TRUE(T_imu_left);
  EXPECT_LT((*T_imu_left * *T_left_imu).translation().norm(), 1e-12);
  EXPECT_FALSE(frames.Between("left_optical", "imu_of_another_robot"));
}

TEST(StaticFrames, LoopsEnd) {
  StaticFrames frames;
  frames.Add("a", "b", SE3());
  frames.Add("b", "a", SE3());
  EXPECT_FALSE(frames.Find("base_link", "a"));
  EXPECT_FALSE(frames.Between("a", "base_link"));
}

}  // namespace
}  // namespace plslam
