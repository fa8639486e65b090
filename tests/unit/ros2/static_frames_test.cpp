// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/static_frames.h"

#include <gtest/gtest.h>

namespace plslam::ros2 {
namespace {

const Eigen::Quaterniond kOptical(0.5, -0.5, 0.5, -0.5);

TEST(Ros2StaticFrames, CameraAtTheEndOfAChain) {
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

TEST(Ros2StaticFrames, LoopsEnd) {
  StaticFrames frames;
  frames.Add("a", "b", SE3());
  frames.Add("b", "a", SE3());
  EXPECT_FALSE(frames.Find("base_link", "a"));
}

}  // namespace
}  // namespace plslam::ros2
