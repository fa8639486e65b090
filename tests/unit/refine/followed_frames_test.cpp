// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/followed_frames.h"

#include <gtest/gtest.h>

namespace plslam::refine {
namespace {

SE3 Along(double x_m) { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x_m, 0.0, 0.0)}; }

Trajectory FramesTo(int n) {
  Trajectory frames;
  for (int i = 0; i < n; ++i) frames.push_back({10 * i, Along(i)});
  return frames;
}

TEST(FollowedFrames, MoveInProportionToTheirTime) {
  const Trajectory moved = FollowKeyframes(FramesTo(7), {{10, Along(0.1)}, {50, Along(0.5)}});
  const double expected[] = {0.1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.5};
  ASSERT_EQ(moved.size(), 7U);
  for (int i = 0; i < 7; ++i) {
    const auto k = static_cast<size_t>(i);
    EXPECT_EQ(moved[k].t_ns, 10 * i);
    EXPECT_NEAR(moved[k].T_a_b.translation().x(), i + expected[i], 1e-12) << i;
  }
}

// A displacement of the map frame turns about its origin, wherever the frame is.
TEST(FollowedFrames, TurnWithTheMap) {
  const SE3 T_new_old(ExpSO3({0.0, 0.0, 0.2}), {0.3, 0.0, 0.0});
  const Trajectory frames = FramesTo(3);
  const Trajectory moved = FollowKeyframes(frames, {{0, T_new_old}, {20, T_new_old}});
  for (size_t i = 0; i < frames.size(); ++i) {
    const SE3 expected = T_new_old * frames[i].T_a_b;
    EXPECT_LT((expected.Inverse() * moved[i].T_a_b).Log().norm(), 1e-12) << i;
  }
}

TEST(FollowedFrames, StayWithoutKeyframes) {
  const Trajectory moved = FollowKeyframes(FramesTo(2), {});
  EXPECT_EQ(moved[1].T_a_b.translation().x(), 1.0);
}

}  // namespace
}  // namespace plslam::refine
