// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/kitti_error.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/support/data_folder.h"
#include "tests/unit/evaluate/pairs.h"

namespace plslam {
namespace {

struct Twin {
  int n = 0;
  double t = 0.0;
  double r = 0.0;
};

// The kit, step by step, with plain matrices and a search from the start for each segment.
Twin SlowTwin(const PosePairs& pairs) {
  Twin twin;
  std::vector<double> distance{0.0};
  for (size_t i = 1; i < pairs.size(); ++i) {
    const Eigen::Vector3d step =
        pairs[i].truth.matrix().topRightCorner<3, 1>() - pairs[i - 1].truth.matrix().topRightCorner<3, 1>();
    distance.push_back(distance.back() + step.norm());
  }
  for (size_t first = 0; first < pairs.size(); first += 10) {
    for (const double length : {100., 200., 300., 400., 500., 600., 700., 800.}) {
      size_t last = first;
      while (last < pairs.size() && !(distance[last] > distance[first] + length)) ++last;
      if (last == pairs.size()) continue;
      const Eigen::Matrix4d truth = pairs[first].truth.matrix().inverse() * pairs[last].truth.matrix();
      const Eigen::Matrix4d estimate = pairs[first].estimate.matrix().inverse() * pairs[last].estimate.matrix();
      const Eigen::Matrix4d error = estimate.inverse() * truth;
      const double d = 0.5 * (error(0, 0) + error(1, 1) + error(2, 2) - 1.0);
      twin.t += error.topRightCorner<3, 1>().norm() / length;
      twin.r += std::acos(std::max(std::min(d, 1.0), -1.0)) / length;
      ++twin.n;
    }
  }
  return twin;
}

TEST(KittiError, MatchesTheSlowTwinOnRealPathsWithDrift) {
  PLSLAM_REQUIRE_DATA(data, "trajectories/kitti");
  const SE3 drift = SE3::Exp((Vector6d() << 0.001, 0.0005, 0.01, 1e-5, 2e-4, -3e-5).finished());
  for (const char* name : {"03.txt", "04.txt", "07.txt", "09.txt"}) {
    const Trajectory truth = ReadTrajectory((data / name).string());
    const PosePairs pairs = Pair(WithDrift(truth, drift), truth);
    const KittiErrors ours = ComputeKittiErrors(pairs);
    const Twin twin = SlowTwin(pairs);
    ASSERT_GT(twin.n, 0);
    EXPECT_EQ(ours.segments, twin.n) << name;
    EXPECT_NEAR(ours.t_rel_percent, 100.0 * twin.t / twin.n, 1e-9) << name;
    EXPECT_NEAR(ours.r_rel_deg_per_100m, 100.0 * 180.0 / M_PI * twin.r / twin.n, 1e-4) << name;
  }
}

// Straight along z, 1 m a frame: a segment of length L ends at the first pose beyond it, L + 1 metres on.
TEST(KittiError, StraightPathWithScaleErrorByHand) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 302; ++i) {
    truth.push_back({i, Translation(0, 0, i)});
    estimate.push_back({i, Translation(0, 0, 1.01 * i)});
  }
  const KittiErrors e = ComputeKittiErrors(Pair(estimate, truth));
  ASSERT_EQ(e.lengths.size(), 3u);
  EXPECT_EQ(e.lengths[0].segments, 21);
  EXPECT_EQ(e.lengths[1].segments, 11);
  EXPECT_EQ(e.lengths[2].segments, 1);
  EXPECT_NEAR(e.lengths[0].t_rel_percent, 1.01, 1e-9);
  EXPECT_NEAR(e.lengths[1].t_rel_percent, 1.0 * 201 / 200, 1e-9);
  EXPECT_NEAR(e.t_rel_percent, (21 * 1.01 + 11 * 1.005 + 301.0 / 300.0) / 33.0, 1e-9);
  EXPECT_EQ(e.r_rel_deg_per_100m, 0.0);
}

TEST(KittiError, ConstantTurnGivesItsRate) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 200; ++i) {
    truth.push_back({i, Translation(0, 0, i)});
    const Eigen::Quaterniond q(Eigen::AngleAxisd(0.001 * i, Eigen::Vector3d::UnitY()));
    estimate.push_back({i, SE3(q, Eigen::Vector3d(0, 0, i))});
  }
  const KittiErrors e = ComputeKittiErrors(Pair(estimate, truth));
  EXPECT_NEAR(e.r_rel_deg_per_100m, 0.101 * 180.0 / M_PI, 1e-9);
}

TEST(KittiError, ShortLengthsStartAtEveryPose) {
  Trajectory truth;
  for (int i = 0; i < 22; ++i) truth.push_back({i, Translation(i, 0, 0)});
  const KittiErrors e = ComputeShortKittiErrors(Pair(truth, truth));
  ASSERT_EQ(e.lengths.size(), 2u);
  EXPECT_EQ(e.lengths[0].segments, 11);
  EXPECT_EQ(e.lengths[1].segments, 1);
  EXPECT_EQ(e.t_rel_percent, 0.0);
}

TEST(KittiError, PathsTooShortAndStandingStillHaveNoSegments) {
  EXPECT_EQ(ComputeKittiErrors({}).segments, 0);
  EXPECT_EQ(ComputeKittiErrors(PosePairs(100)).segments, 0);
  EXPECT_EQ(ComputeKittiErrors(PosePairs(1)).t_rel_percent, 0.0);
}

}  // namespace
}  // namespace plslam
