// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/held_infos.h"

#include <gtest/gtest.h>

namespace plslam::ros2 {
namespace {

using robot::Side;

RosCameraInfo InfoOf(int width_px) {
  RosCameraInfo info;
  info.width_px = width_px;
  return info;
}

const SE3 kForward(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.3, 0.0, 0.0));

/// A robot whose left camera takes images in "left".
class HeldInfosTest : public testing::Test {
 protected:
  void AddBoth() {
    infos_.Add(Side::kLeft, InfoOf(640), "left", 10.0);
    infos_.Add(Side::kRight, InfoOf(641), "right", 10.1);
  }
  std::optional<HeldInfos::Ready> Take(double now_s, bool has_publisher = true) {
    return infos_.Take(rig_, now_s, [has_publisher] { return has_publisher; });
  }

  HeldInfos infos_{"base_link"};
  HeldInfos::Rig rig_;
};

TEST_F(HeldInfosTest, BothSidesAreNeeded) {
  EXPECT_FALSE(Take(20.0, false));
  infos_.Add(Side::kRight, InfoOf(641), "right", 10.0);
  EXPECT_FALSE(Take(20.0, false));
  infos_.Add(Side::kLeft, InfoOf(640), "left", 10.1);
  const auto ready = Take(20.1, false);
  ASSERT_TRUE(ready);
  EXPECT_EQ(ready->left.width_px, 640);
  EXPECT_EQ(ready->right.value().width_px, 641);
  EXPECT_FALSE(ready->T_b_l);
  EXPECT_EQ(infos_.left_frame(), "left");
  EXPECT_FALSE(Take(20.2, false)) << "they were taken";
}

TEST_F(HeldInfosTest, DepthsHaveNone) {
  rig_.is_rgbd = true;
  infos_.Add(Side::kLeft, InfoOf(640), "left", 10.0);
  const auto ready = Take(20.0, false);
  ASSERT_TRUE(ready);
  EXPECT_FALSE(ready->right);
}

TEST_F(HeldInfosTest, PublisherOfFramesMayComeAfterTheCamera) {
  AddBoth();
  EXPECT_FALSE(Take(10.1, false));
  EXPECT_TRUE(infos_.awaits_frames());
  EXPECT_FALSE(Take(9.9 + HeldInfos::kDiscovery_s, false));
  EXPECT_FALSE(Take(10.1 + HeldInfos::kDiscovery_s)) << "it is there: its message may be under way";
  infos_.AddFrame("base_link", "left", kForward);
  EXPECT_TRUE(Take(10.2 + HeldInfos::kDiscovery_s).value().T_b_l);
}

TEST_F(HeldInfosTest, WithoutAPublisherTheWaitIsShort) {
  AddBoth();
  EXPECT_FALSE(Take(10.1, false));
  EXPECT_TRUE(Take(10.0 + HeldInfos::kDiscovery_s, false));
}

TEST_F(HeldInfosTest, FirstRigWaitsForStaticFrames) {
  AddBoth();
  EXPECT_FALSE(Take(10.1));
  EXPECT_TRUE(infos_.awaits_frames());
  EXPECT_FALSE(Take(10.0 + HeldInfos::kPatience_s - 0.01));
  infos_.AddFrame("base_link", "left", kForward);
  const auto ready = Take(10.2);
  ASSERT_TRUE(ready);
  EXPECT_FALSE(infos_.awaits_frames());
  EXPECT_EQ(ready->T_b_l.value().translation(), kForward.translation());
}

TEST_F(HeldInfosTest, WaitEndsAfterAWhile) {
  AddBoth();
  EXPECT_FALSE(Take(10.1));
  // Newer infos do not prolong it.
  infos_.Add(Side::kLeft, InfoOf(642), "left", 14.0);
  const auto ready = Take(10.0 + HeldInfos::kPatience_s);
  ASSERT_TRUE(ready);
  EXPECT_EQ(ready->left.width_px, 642);
  EXPECT_FALSE(ready->T_b_l);
  EXPECT_FALSE(infos_.awaits_frames());
}

TEST_F(HeldInfosTest, RigInUseDoesNotWait) {
  rig_.is_known = true;
  AddBoth();
  EXPECT_TRUE(Take(10.1));
}

TEST_F(HeldInfosTest, InertialSensorNeedsItsPoseToo) {
  rig_.needs_imu_pose = true;
  infos_.AddFrame("base_link", "left", kForward);
  infos_.AddFrame("base_link", "imu", SE3());
  AddBoth();
  EXPECT_FALSE(Take(10.1)) << "the sensor has not named its frame";
  rig_.imu_frame = "imu";
  const auto ready = Take(10.2);
  ASSERT_TRUE(ready);
  EXPECT_EQ(ready->T_l_imu.value().translation(), -kForward.translation());
}

}  // namespace
}  // namespace plslam::ros2
