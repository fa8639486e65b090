// SPDX-License-Identifier: BSD-3-Clause
#include "core/accuracy/association.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <tuple>

#include "tests/unit/evaluate/pairs.h"

namespace plslam::evaluate {
namespace {

Trajectory AtTimes(const std::vector<int64_t>& times) {
  Trajectory trajectory;
  for (const int64_t t : times) trajectory.push_back({t, Translation(static_cast<double>(t), 0, 0)});
  return trajectory;
}

std::vector<std::pair<int64_t, int64_t>> Times(const PosePairs& pairs) {
  std::vector<std::pair<int64_t, int64_t>> times;
  for (const PosePair& pair : pairs) times.emplace_back(pair.t_ns, std::llround(pair.truth.translation().x()));
  return times;
}

// Sturm's script: all pairs within the bound, sorted by difference, taken while both are free.
std::vector<std::pair<int64_t, int64_t>> SlowTwin(const Trajectory& a, const Trajectory& b, int64_t bound) {
  std::vector<std::tuple<int64_t, size_t, size_t>> all;
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t j = 0; j < b.size(); ++j) {
      const int64_t difference = std::abs(a[i].t_ns - b[j].t_ns);
      if (difference <= bound) all.emplace_back(difference, i, j);
    }
  }
  std::sort(all.begin(), all.end());
  std::set<size_t> used_a;
  std::set<size_t> used_b;
  std::vector<std::pair<int64_t, int64_t>> pairs;
  for (const auto& [difference, i, j] : all) {
    if (used_a.count(i) > 0 || used_b.count(j) > 0) continue;
    used_a.insert(i);
    used_b.insert(j);
    pairs.emplace_back(a[i].t_ns, b[j].t_ns);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

TEST(Association, EachPoseIsUsedOnceAndTheClosestFirst) {
  const auto pairs = Times(AssociateNearest(AtTimes({0, 10, 20}), AtTimes({9, 12, 50}), 10));
  const std::vector<std::pair<int64_t, int64_t>> expected{{10, 9}, {20, 12}};
  EXPECT_EQ(pairs, expected);
}

TEST(Association, BoundIsInclusive) {
  EXPECT_EQ(AssociateNearest(AtTimes({0}), AtTimes({10}), 10).size(), 1u);
  EXPECT_EQ(AssociateNearest(AtTimes({0}), AtTimes({10}), 9).size(), 0u);
  EXPECT_EQ(AssociateNearest(AtTimes({5}), AtTimes({5}), 0).size(), 1u);
}

TEST(Association, EmptyTrajectories) {
  EXPECT_TRUE(AssociateNearest({}, {}, 10).empty());
  EXPECT_TRUE(AssociateNearest(AtTimes({1}), {}, 10).empty());
  EXPECT_TRUE(AssociateInterpolated({}, AtTimes({1}), 10).empty());
  EXPECT_TRUE(AssociateInterpolated(AtTimes({1}), {}, 10).empty());
}

TEST(Association, MatchesTheSlowTwinOnRandomTimes) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 200; ++trial) {
    const auto draw = [&](size_t n) {
      std::set<int64_t> times;
      while (times.size() < n) times.insert(static_cast<int64_t>(random() % 300));
      return AtTimes({times.begin(), times.end()});
    };
    const Trajectory a = draw(5 + random() % 40);
    const Trajectory b = draw(5 + random() % 40);
    const int64_t bound = static_cast<int64_t>(random() % 30);
    ASSERT_EQ(Times(AssociateNearest(a, b, bound)), SlowTwin(a, b, bound)) << "trial " << trial;
  }
}

TEST(Association, InterpolationIsExactOnAScrewOfConstantTurn) {
  const SE3 a = Translation(1, 0, 0);
  const SE3 b(Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ())), Eigen::Vector3d(3, 2, 0));
  const Trajectory truth{{0, a}, {100, b}};
  const PosePairs pairs = AssociateInterpolated(AtTimes({-1, 0, 25, 100, 101}), truth, 100);
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].estimate_index, 1);
  EXPECT_LT((pairs[1].truth.translation() - Eigen::Vector3d(1.5, 0.5, 0)).norm(), 1e-12);
  EXPECT_NEAR(pairs[1].truth.Log().tail<3>().z(), 0.25, 1e-12);
  EXPECT_LT((pairs[2].truth.translation() - b.translation()).norm(), 1e-12);
}

TEST(Association, InterpolationDoesNotCrossALargerGap) {
  EXPECT_EQ(AssociateInterpolated(AtTimes({50}), AtTimes({0, 100}), 99).size(), 0u);
  EXPECT_EQ(AssociateInterpolated(AtTimes({50}), AtTimes({0, 100}), 100).size(), 1u);
}

}  // namespace
}  // namespace plslam::evaluate
