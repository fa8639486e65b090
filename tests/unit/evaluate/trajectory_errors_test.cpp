// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/trajectory_errors.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/accuracy/consistency.h"
#include "tests/support/data_folder.h"
#include "tests/unit/evaluate/pairs.h"

namespace plslam::evaluate {
namespace {

TEST(AbsoluteError, OffsetAndTurnByHand) {
  const SE3 turned(Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY())), Eigen::Vector3d(3, 4, 0));
  const AbsoluteErrors errors = ComputeAbsoluteErrors({{0, turned, SE3(), 0}}, {}, Eigen::Quaterniond::Identity());
  EXPECT_DOUBLE_EQ(errors.translation_m.at(0), 5.0);
  EXPECT_NEAR(errors.rotation_rad.at(0), 0.1, 1e-12);
}

TEST(AbsoluteError, AngleIsTheShorterOne) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond minus_q(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_NEAR(AngleBetween(q, minus_q), 0.0, 1e-12);
  EXPECT_NEAR(AngleBetween(Eigen::Quaterniond::Identity(), minus_q), 3.0, 1e-12);
}

// Along z at 1 m a frame and 10 Hz, estimated 2 % too long.
PosePairs TooLong(int n) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < n; ++i) {
    truth.push_back({i * 100'000'000LL, Translation(0, 0, i)});
    estimate.push_back({i * 100'000'000LL, Translation(0, 0, 1.02 * i)});
  }
  return Pair(estimate, truth);
}

TEST(RelativeError, ScaleErrorOverFramesSecondsAndMetres) {
  const PosePairs pairs = TooLong(31);
  for (const char* delta : {"10f", "1s", "10m"}) {
    const RelativeErrors errors = ComputeRelativeErrors(pairs, DeltaFromText(delta));
    EXPECT_EQ(errors.translation_m.size(), 21u) << delta;
    for (const double e : errors.translation_m) EXPECT_NEAR(e, 0.2, 1e-12) << delta;
    EXPECT_EQ(Summarise(errors.rotation_rad).max, 0.0);
  }
}

TEST(RelativeError, ConstantDriftIsTheErrorOfEachFrame) {
  const SE3 drift = SE3::Exp((Vector6d() << 0.003, 0, 0.004, 0, 0.01, 0).finished());
  const Trajectory truth = SomePath(40);
  const RelativeErrors errors = ComputeRelativeErrors(Pair(WithDrift(truth, drift), truth), {});
  ASSERT_EQ(errors.translation_m.size(), 39u);
  for (size_t i = 0; i < 39; ++i) {
    EXPECT_NEAR(errors.translation_m[i], drift.translation().norm(), 1e-12);
    EXPECT_NEAR(errors.rotation_rad[i], 0.01, 1e-12);
  }
}

TEST(RelativeError, DoesNotDependOnTheFrameOfTheEstimate) {
  const SE3 move = SE3::Exp((Vector6d() << 9, 8, 7, 1, 2, -1).finished());
  PosePairs pairs = TooLong(20);
  const double before = Summarise(ComputeRelativeErrors(pairs, DeltaFromText("5f")).translation_m).rmse;
  for (PosePair& pair : pairs) pair.estimate = move * pair.estimate;
  EXPECT_NEAR(Summarise(ComputeRelativeErrors(pairs, DeltaFromText("5f")).translation_m).rmse, before, 1e-12);
}

TEST(RelativeError, GapsLargerThanTheDeltaAreLeftOut) {
  PosePairs pairs = TooLong(4);
  pairs[2].t_ns += 5'000'000'000;
  pairs[3].t_ns += 5'000'000'000;
  EXPECT_EQ(ComputeRelativeErrors(pairs, DeltaFromText("0.1s")).translation_m.size(), 2u);
}

TEST(RelativeError, NoPairOnePairAndStandingStill) {
  for (const char* delta : {"1f", "1s", "1m"}) {
    EXPECT_TRUE(ComputeRelativeErrors({}, DeltaFromText(delta)).translation_m.empty());
    EXPECT_TRUE(ComputeRelativeErrors(TooLong(1), DeltaFromText(delta)).translation_m.empty());
  }
  const PosePairs still(5, PosePair{});
  EXPECT_TRUE(ComputeRelativeErrors(still, DeltaFromText("1m")).translation_m.empty());
}

TEST(RelativeError, DeltaTexts) {
  for (const char* text : {"5f", "1s", "2.5m"}) EXPECT_EQ(DeltaText(DeltaFromText(text)), text);
  for (const char* text : {"", "5", "f", "1.5f", "-1s", "0m", "nans", "infm", "1 s", "1km"}) {
    EXPECT_THROW(DeltaFromText(text), std::runtime_error) << text;
  }
}

TEST(KeyframeError, ScaleErrorByHand) {
  const KeyframeErrors e = ComputeKeyframeErrors(TooLong(21), {0, 500'000'000, 2'000'000'000});
  EXPECT_EQ(e.motions, 2);
  EXPECT_EQ(e.moving, 2);
  EXPECT_NEAR(e.rmse_m, std::sqrt((0.1 * 0.1 + 0.3 * 0.3) / 2.0), 1e-12);
  EXPECT_NEAR(e.relative_rmse, 0.02, 1e-12);
  EXPECT_NEAR(e.t_rel_percent, 2.0, 1e-9);
  EXPECT_EQ(e.R_rel_deg_per_100m, 0.0);
}

TEST(KeyframeError, RotationIsPerDistance) {
  PosePairs pairs = TooLong(2);
  pairs[1].estimate =
      SE3(Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY())), pairs[1].estimate.translation());
  const KeyframeErrors e = ComputeKeyframeErrors(pairs, {0, 100'000'000});
  EXPECT_NEAR(e.R_rel_deg_per_100m, 100.0 * 0.01 * 180.0 / M_PI, 1e-9);
}

TEST(KeyframeError, StandingStillHasNoRelativeFigures) {
  PosePairs still(3, PosePair{});
  for (int i = 0; i < 3; ++i) still[i].t_ns = i;
  const KeyframeErrors e = ComputeKeyframeErrors(still, {0, 1, 2});
  EXPECT_EQ(e.motions, 2);
  EXPECT_EQ(e.moving, 0);
  EXPECT_EQ(e.relative_rmse, 0.0);
}

TEST(KeyframeError, NoOrUnknownKeyframes) {
  EXPECT_EQ(ComputeKeyframeErrors(TooLong(5), {}).motions, 0);
  EXPECT_EQ(ComputeKeyframeErrors(TooLong(5), {7, 8, 9}).motions, 0);
}

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
}  // namespace plslam::evaluate
