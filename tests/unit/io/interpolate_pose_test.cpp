#include "core/io/interpolate_pose.h"

#include <gtest/gtest.h>

#include <limits>

namespace plslam {
namespace {

TrajectoryPose At(int64_t t_ns, double x, double angle_rad) {
  return {t_ns, SE3(ExpSO3({0.0, 0.0, angle_rad}), {x, 0.0, 0.0})};
}

TEST(InterpolatePose, BetweenOnAndOutside) {
  const Trajectory trajectory = {At(100, 0.0, 0.0), At(200, 1.0, 1.0), At(600, 5.0, 1.0)};
  EXPECT_FALSE(InterpolatePose(trajectory, 99, 1000));
  EXPECT_FALSE(InterpolatePose(trajectory, 601, 1000));
  EXPECT_EQ(InterpolatePose(trajectory, 100, 1000)->translation().x(), 0.0);
  EXPECT_EQ(InterpolatePose(trajectory, 600, 1)->translation().x(), 5.0);
  const SE3 quarter = *InterpolatePose(trajectory, 125, 1000);
  EXPECT_NEAR(quarter.translation().x(), 0.25, 1e-12);
  EXPECT_NEAR(quarter.Log().tail<3>().z(), 0.25, 1e-12);
  EXPECT_FALSE(InterpolatePose(trajectory, 300, 399)) << "the gap of 400 is too long";
  EXPECT_NEAR(InterpolatePose(trajectory, 300, 400)->translation().x(), 2.0, 1e-12);
}

TEST(InterpolatePose, QuaternionsOfOppositeSignAreTheSameRotation) {
  TrajectoryPose b = At(10, 0.0, 0.2);
  b.T_a_b = SE3(Eigen::Quaterniond(-b.T_a_b.rotation().coeffs()), b.T_a_b.translation());
  EXPECT_NEAR(InterpolatePose({At(0, 0.0, 0.0), b}, 5, 100)->Log().tail<3>().z(), 0.1, 1e-12);
}

TEST(InterpolatePose, EmptyAndExtremeTimes) {
  EXPECT_FALSE(InterpolatePose({}, 0, 100));
  const int64_t max = std::numeric_limits<int64_t>::max();
  EXPECT_FALSE(InterpolatePose({At(0, 0.0, 0.0), At(max, 1.0, 0.0)}, max - 1, 100));
}

}  // namespace
}  // namespace plslam
