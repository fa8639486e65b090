// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/trajectory.h"

#include <gtest/gtest.h>

#include <limits>

namespace plslam {
namespace {

constexpr int64_t kMs = 1'000'000;

TrajectoryPose At(int64_t t_ns, double x, double angle_rad) {
  return {t_ns, SE3(ExpSO3({0.0, 0.0, angle_rad}), {x, 0.0, 0.0})};
}

TEST(InterpolatePose, BetweenOnAndOutside) {
  const Trajectory trajectory = {At(100 * kMs, 0.0, 0.0), At(200 * kMs, 1.0, 1.0), At(600 * kMs, 5.0, 1.0)};
  EXPECT_FALSE(InterpolatePose(trajectory, 98 * kMs, 1000 * kMs));
  EXPECT_FALSE(InterpolatePose(trajectory, 602 * kMs, 1000 * kMs));
  EXPECT_EQ(InterpolatePose(trajectory, 100 * kMs, 1000 * kMs)->translation().x(), 0.0);
  EXPECT_EQ(InterpolatePose(trajectory, 600 * kMs, 1)->translation().x(), 5.0);
  const SE3 quarter = *InterpolatePose(trajectory, 125 * kMs, 1000 * kMs);
  EXPECT_NEAR(quarter.translation().x(), 0.25, 1e-12);
  EXPECT_NEAR(quarter.Log().tail<3>().z(), 0.25, 1e-12);
  EXPECT_FALSE(InterpolatePose(trajectory, 300 * kMs, 399 * kMs)) << "the gap of 400 is too long";
  EXPECT_NEAR(InterpolatePose(trajectory, 300 * kMs, 400 * kMs)->translation().x(), 2.0, 1e-12);
}

TEST(InterpolatePose, PoseAtTheSameTimeNeedsNoNeighbour) {
  const Trajectory trajectory = {At(100 * kMs, 0.0, 0.0), At(300 * kMs, 1.0, 0.0)};
  const auto x = [&](int64_t t_ns, int64_t max_gap_ns) {
    const auto pose = InterpolatePose(trajectory, t_ns, max_gap_ns);
    return pose ? pose->translation().x() : -1.0;
  };
  EXPECT_EQ(x(99 * kMs, 0), 0.0) << "before the first, by a millisecond of rounding";
  EXPECT_EQ(x(101 * kMs, 150 * kMs), 0.0) << "beside a gap";
  EXPECT_EQ(x(299 * kMs, 150 * kMs), 1.0);
  EXPECT_EQ(x(301 * kMs, 150 * kMs), 1.0);
  EXPECT_EQ(x(101 * kMs + 1, 150 * kMs), -1.0);
  EXPECT_EQ(x(301 * kMs + 1, 150 * kMs), -1.0);
  EXPECT_NEAR(x(101 * kMs, 200 * kMs), 0.005, 1e-12) << "where there is one on either side it is interpolated";
}

TEST(InterpolatePose, QuaternionsOfOppositeSignAreTheSameRotation) {
  TrajectoryPose b = At(10, 0.0, 0.2);
  b.T_a_b = SE3(Eigen::Quaterniond(-b.T_a_b.rotation().coeffs()), b.T_a_b.translation());
  EXPECT_NEAR(InterpolatePose({At(0, 0.0, 0.0), b}, 5, 100)->Log().tail<3>().z(), 0.1, 1e-12);
}

TEST(InterpolatePose, EmptyAndExtremeTimes) {
  EXPECT_FALSE(InterpolatePose({}, 0, 100));
  const int64_t max = std::numeric_limits<int64_t>::max();
  EXPECT_FALSE(InterpolatePose({At(0, 0.0, 0.0), At(max, 1.0, 0.0)}, max - 2 * kMs, 100));
}

}  // namespace
}  // namespace plslam
