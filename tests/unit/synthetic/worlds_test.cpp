// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/worlds.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>

#include "core/datasets/synthetic/exact_math.h"
#include "core/datasets/synthetic/simulator.h"

namespace plslam::synthetic {
namespace {

int Corners(const Simulator& simulator, int index) {
  std::vector<cv::KeyPoint> corners;
  cv::FAST(simulator.Render(index).left, corners, 20);
  return static_cast<int>(corners.size());
}

double PathLength(const Simulator& simulator) {
  double length = 0.0;
  for (int i = 1; i < simulator.size(); ++i) {
    length += (simulator.T_w_c(i).translation() - simulator.T_w_c(i - 1).translation()).norm();
  }
  return length;
}

TEST(Worlds, WhitewallHasHardlyAnyCornersAndTheRoomMany) {
  const Simulator whitewall(ParseOptions("whitewall"));
  const Simulator room(ParseOptions("room"));
  for (const int index : {0, 60, 120, 180, 240}) {
    EXPECT_LT(Corners(whitewall, index), 45) << "frame " << index;
    EXPECT_GT(Corners(room, index), 600) << "frame " << index;
  }
}

TEST(Worlds, CameraKeepsClearOfEverything) {
  for (const WorldKind& kind : WorldKinds()) {
    const Simulator simulator(ParseOptions(std::string(kind.name) + "?size=96x64"));
    for (int i = 0; i < 60; ++i) {
      const int index = i * (simulator.size() - 1) / 60;
      const std::vector<float> depth = simulator.RenderDepth(index);
      const auto in_view = [](float z) { return z > 0.0F ? z : 1e9F; };
      float nearest = 1e9F;
      for (const float z : depth) {
        nearest = std::min(nearest, in_view(z));
      }
      EXPECT_GE(nearest, 0.5F) << kind.name << " frame " << index;
    }
  }
}

TEST(Worlds, MotionIsSmooth) {
  for (const WorldKind& kind : WorldKinds()) {
    const Simulator simulator(ParseOptions(std::string(kind.name) + "?size=32x32"));
    for (int i = 2; i < simulator.size(); ++i) {
      const Vector6d step = (simulator.T_w_c(i - 1).Inverse() * simulator.T_w_c(i)).Log();
      const Vector6d before = (simulator.T_w_c(i - 2).Inverse() * simulator.T_w_c(i - 1)).Log();
      EXPECT_LT(step.tail<3>().norm() * 20.0 * 180.0 / kPi, 60.0) << kind.name << " degrees/s at frame " << i;
      EXPECT_LT((step - before).tail<3>().norm() * 180.0 / kPi, 0.6) << kind.name << " frame " << i;
    }
  }
}

TEST(Worlds, LapsHaveTheDocumentedLength) {
  EXPECT_NEAR(PathLength(Simulator(ParseOptions("room?size=32x32"))), 15.0, 0.6);
  EXPECT_GT(PathLength(Simulator(ParseOptions("room?size=32x32&frames=1201"))), 60.0);
  EXPECT_NEAR(PathLength(Simulator(ParseOptions("corridor?size=32x32"))), 61.5, 1.0);
  EXPECT_GT(PathLength(Simulator(ParseOptions("street?size=32x32"))), 300.0);
  EXPECT_NEAR(PathLength(Simulator(ParseOptions("whitewall?size=32x32"))), 13.5, 0.6);
}

TEST(Worlds, CameraTurnsOnTheSpot) {
  const Simulator simulator(ParseOptions("room?size=32x32&frames=101&turning=40&imu=200&imu_class=exact"));
  const SE3 T_first_last = simulator.T_w_c(0).Inverse() * simulator.T_w_c(100);  // after 5 s
  EXPECT_LT(T_first_last.translation().norm(), 1e-9);
  EXPECT_NEAR(T_first_last.Log().tail<3>().norm(), 160.0 * kPi / 180.0, 1e-6) << "200 degrees";
  const Eigen::Vector3d rate_rad_s = simulator.imu_samples().at(500).rate_rad_s;
  EXPECT_NEAR(rate_rad_s.norm(), 40.0 * kPi / 180.0, 1e-6);
  EXPECT_GT(rate_rad_s.z(), 0.6) << "to the left";
}

TEST(Worlds, GroundTruthHoldsPointsAndSegments) {
  for (const WorldKind& kind : WorldKinds()) {
    const Simulator simulator(ParseOptions(std::string(kind.name) + "?size=32x32&frames=1"));
    EXPECT_GE(simulator.world().segments().size(), 100u) << kind.name;
    EXPECT_GE(simulator.world().points().size(), 50u) << kind.name;
  }
}

}  // namespace
}  // namespace plslam::synthetic
