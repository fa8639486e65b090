// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/robot_path.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/vo/feature_path.h"

namespace plslam::vo {
namespace {

using test::PathAt;

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kBegin_ns = 1'000'000'000'000;

/// A pose every 20 ms, of which three are one and a half frames of `PathAt`.
RobotPath Path(int n_poses) {
  RobotPath path;
  for (int i = 0; i < n_poses; ++i) path.Add(kBegin_ns + 20 * kMs * i, PathAt(0.5 * i));
  return path;
}

SE3 Truth(int64_t from_ms, int64_t to_ms) {
  const auto at = [](int64_t ms) { return PathAt(0.025 * static_cast<double>(ms)); };
  return at(from_ms).Inverse() * at(to_ms);
}

double Off(const std::optional<SE3>& motion, int64_t from_ms, int64_t to_ms) {
  return motion ? (motion->Inverse() * Truth(from_ms, to_ms)).Log().norm() : 1e9;
}

std::optional<SE3> Motion(const RobotPath& path, int64_t from_ms, int64_t to_ms) {
  return path.Motion(kBegin_ns + from_ms * kMs, kBegin_ns + to_ms * kMs);
}

TEST(RobotPath, InterpolatesBetweenThePosesAroundBothTimes) {
  const RobotPath path = Path(50);
  EXPECT_LT(Off(Motion(path, 100, 200), 100, 200), 1e-9) << "at poses";
  EXPECT_LT(Off(Motion(path, 107, 151), 107, 151), 1e-5);
  EXPECT_LT(Off(Motion(path, 11, 970), 11, 970), 1e-5);
}

TEST(RobotPath, ExtrapolatesBrieflyBeyondTheNewestPose) {
  const RobotPath path = Path(50);
  EXPECT_TRUE(path.Reaches(kBegin_ns + 980 * kMs));
  EXPECT_FALSE(path.Reaches(kBegin_ns + 980 * kMs + 1));
  EXPECT_LT(Off(Motion(path, 950, 1000), 950, 1000), 1e-3);
  EXPECT_FALSE(Motion(path, 950, 1100));
  RobotPath slow;
  for (int i = 0; i < 10; ++i) slow.Add(kBegin_ns + 100 * kMs * i, PathAt(2.5 * i));
  EXPECT_LT(Off(Motion(slow, 950, 1040), 950, 1040), 3e-3) << "10 a second, one late";
  EXPECT_FALSE(Motion(slow, 950, 1060));
  RobotPath one;
  one.Add(kBegin_ns, SE3());
  EXPECT_FALSE(Motion(one, 0, 10)) << "one pose tells no motion";
}

TEST(RobotPath, NoMotionOutsideItsPoses) {
  EXPECT_FALSE(Motion(RobotPath(), 0, 50));
  EXPECT_FALSE(Motion(Path(50), -10, 50)) << "before the first pose";
  EXPECT_FALSE(Motion(Path(50), 50, 50));
  EXPECT_FALSE(Motion(Path(50), 100, 50));
  RobotPath path = Path(10);
  path.Add(kBegin_ns + 1000 * kMs, PathAt(25));
  EXPECT_FALSE(Motion(path, 100, 500)) << "0.8 s without a pose";
}

TEST(RobotPath, LateAndRepeatedPosesAreIgnored) {
  RobotPath path;
  for (const int i : {0, 1, 3, 2, 3, 4, 4, 5}) path.Add(kBegin_ns + 20 * kMs * i, PathAt(0.5 * i));
  EXPECT_LT(Off(Motion(path, 0, 100), 0, 100), 1e-9);
  EXPECT_LT(Off(Motion(path, 30, 50), 30, 50), 1e-3) << "around the one that was late";
}

TEST(RobotPath, RestartsIfTimeDecreasesOrThePoseJumps) {
  RobotPath path = Path(100);
  path.Add(kBegin_ns, SE3());
  path.Add(kBegin_ns + 20 * kMs, SE3());
  EXPECT_FALSE(Motion(path, 100, 200));
  EXPECT_LT(Motion(path, 0, 20)->Log().norm(), 1e-12);

  RobotPath jumped = Path(50);
  const SE3 far(Eigen::Quaterniond::Identity(), {40.0, 0.0, 0.0});
  for (int i = 50; i < 60; ++i) jumped.Add(kBegin_ns + 20 * kMs * i, far * PathAt(0.5 * i));
  EXPECT_FALSE(Motion(jumped, 950, 1050)) << "across the jump";
  EXPECT_LT(Off(Motion(jumped, 1050, 1100), 1050, 1100), 1e-3);
}

TEST(RobotPath, TimesMayBeAny) {
  RobotPath path;
  for (const int64_t t_ns : {std::numeric_limits<int64_t>::min(), int64_t{0}, std::numeric_limits<int64_t>::max()}) {
    path.Add(t_ns, SE3());
  }
  EXPECT_FALSE(path.Motion(std::numeric_limits<int64_t>::min(), 5));
  EXPECT_TRUE(path.Motion(std::numeric_limits<int64_t>::min(), std::numeric_limits<int64_t>::max()));
}

}  // namespace
}  // namespace plslam::vo
