// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/accuracy/consistency.h"
#include "tests/unit/evaluate/pairs.h"
#include "tools/evaluate/trajectory_errors.h"

namespace plslam::evaluate {
namespace {

const SE3 kMove = SE3::Exp((Vector6d() << 5, -3, 2, 0.5, -1.1, 2.0).finished());

// Truth = scale and kMove applied to the estimate.
PosePairs MovedPairs(const Trajectory& estimate, double scale) {
  const Similarity move{scale, kMove};
  Trajectory truth;
  for (const TrajectoryPose& pose : estimate) truth.push_back({pose.t_ns, move.Apply(pose.T_a_b)});
  return Pair(estimate, truth);
}

double Distance(const SE3& a, const SE3& b) { return (a.Inverse() * b).Log().norm(); }

Trajectory Line(int n) {
  Trajectory line;
  const SE3 start = SE3::Exp((Vector6d() << 7, 1, -2, 0.3, 0.2, -0.7).finished());
  for (int i = 0; i < n; ++i) line.push_back({i, start * Translation(0.3 * i, -0.1 * i, 0.5 * i)});
  return line;
}

TEST(Alignment, RigidMotionIsRecovered) {
  const Similarity s = Align(MovedPairs(SomePath(50), 1.0), Alignment::kSe3);
  EXPECT_EQ(s.scale, 1.0);
  EXPECT_LT(Distance(s.T_a_b, kMove), 1e-9);
}

TEST(Alignment, SimilarityIsRecovered) {
  const Similarity s = Align(MovedPairs(SomePath(50), 2.5), Alignment::kSim3);
  EXPECT_NEAR(s.scale, 2.5, 1e-12);
  EXPECT_LT(Distance(s.T_a_b, kMove), 1e-9);
}

TEST(Alignment, AgreesWithEigensUmeyamaOnDriftingPaths) {
  const Trajectory truth = SomePath(80);
  const PosePairs pairs =
      Pair(WithDrift(truth, SE3::Exp((Vector6d() << 0.02, 0, 0.01, 0, 0.004, 0.002).finished())), truth);
  Eigen::Matrix3Xd from(3, pairs.size());
  Eigen::Matrix3Xd to(3, pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = pairs[i].estimate.translation();
    to.col(static_cast<Eigen::Index>(i)) = pairs[i].truth.translation();
  }
  for (const bool with_scale : {false, true}) {
    const Similarity ours = Align(pairs, with_scale ? Alignment::kSim3 : Alignment::kSe3);
    Eigen::Matrix4d m = ours.T_a_b.matrix();
    m.topLeftCorner<3, 3>() *= ours.scale;
    const Eigen::Matrix4d theirs = Eigen::umeyama(from, to, with_scale);
    EXPECT_LT((m - theirs).norm(), 1e-9) << "scale " << with_scale << "\n" << m << "\n" << theirs;
  }
}

TEST(Alignment, PlanarPathGetsARotationAndNoReflection) {
  Trajectory plane;
  for (int i = 0; i < 20; ++i) plane.push_back({i, Translation(std::cos(0.3 * i), std::sin(0.3 * i), 0)});
  const Similarity s = Align(MovedPairs(plane, 1.0), Alignment::kSe3);
  EXPECT_LT(Distance(s.T_a_b, kMove), 1e-9);
}

TEST(Alignment, RollAboutAStraightPath) {
  for (const int n : {2, 3, 30}) {
    for (const auto kind : {Alignment::kSe3, Alignment::kSim3}) {
      const Similarity s = Align(MovedPairs(Line(n), 1.0), kind);
      EXPECT_NEAR(s.scale, 1.0, 1e-12);
      EXPECT_LT(Distance(s.T_a_b, kMove), 1e-7) << n << " poses";
    }
  }
}

TEST(Alignment, OppositeStraightPathsGiveARotation) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 5; ++i) {
    truth.push_back({i, Translation(i, 0, 0)});
    estimate.push_back({i, Translation(-i, 0, 0)});
  }
  const PosePairs pairs = Pair(estimate, truth);
  const Similarity s = Align(pairs, Alignment::kSe3);
  EXPECT_NEAR(s.T_a_b.R().determinant(), 1.0, 1e-12);
  EXPECT_LT(Summarise(ComputeAbsoluteErrors(pairs, s, s.T_a_b.rotation()).translation_m).max, 1e-12);
}

TEST(Alignment, StandingStillIsAlignedByOrientation) {
  const Trajectory still{{0, kMove}, {1, kMove}, {2, kMove}};
  for (const auto kind : {Alignment::kSe3, Alignment::kSim3, Alignment::kFirst}) {
    const Similarity s = Align(MovedPairs(still, 1.0), kind);
    EXPECT_EQ(s.scale, 1.0);
    EXPECT_LT(Distance(s.T_a_b, kMove), 1e-9);
  }
}

TEST(Alignment, NoneAndNothingAreIdentity) {
  EXPECT_EQ(Align({}, Alignment::kSim3).scale, 1.0);
  for (const auto kind : {Alignment::kSe3, Alignment::kSim3, Alignment::kFirst, Alignment::kNone}) {
    EXPECT_LT(Align({}, kind).T_a_b.Log().norm(), 1e-15);
  }
  EXPECT_LT(Align(MovedPairs(SomePath(5), 1.0), Alignment::kNone).T_a_b.Log().norm(), 1e-15);
}

TEST(Alignment, OnePoseIsAlignedExactly) {
  for (const auto kind : {Alignment::kSe3, Alignment::kSim3, Alignment::kFirst}) {
    EXPECT_LT(Distance(Align(MovedPairs(SomePath(1), 1.0), kind).T_a_b, kMove), 1e-9);
  }
}

TEST(Alignment, NamesRoundTrip) {
  for (const char* name : {"none", "first", "se3", "sim3"})
    EXPECT_STREQ(NameOf(*ChoiceFromName<Alignment>(name)), name);
  EXPECT_FALSE(ChoiceFromName<Alignment>("rigid").has_value());
}

constexpr int64_t kMaxClockGap_ns = 50'000'000;

SE3 OnCurve(double t_s) {
  return {ExpSO3({0.0, 0.4 * t_s, 0.0}), {std::sin(1.3 * t_s), 0.5 * std::sin(0.7 * t_s), std::cos(t_s)}};
}

// The camera at `rate_hz`, whose clock is `late_s` ahead of the true time.
Trajectory Along(double rate_hz, double late_s, double duration_s = 8.0) {
  Trajectory trajectory;
  for (int i = 0; i < duration_s * rate_hz; ++i) {
    const double t_s = i / rate_hz;
    trajectory.push_back({std::llround(1e9 * (t_s + late_s)), OnCurve(t_s)});
  }
  return trajectory;
}

TEST(ClockOffset, IsFound) {
  const Trajectory truth = Along(200.0, 0.0);
  for (const double late_s : {-0.0123, 0.0, 0.007, 0.031}) {
    const auto clock = FitClockOffset(Along(10.0, late_s), truth, Alignment::kSe3, kMaxClockGap_ns, 0.05);
    ASSERT_TRUE(clock) << late_s;
    EXPECT_NEAR(clock->offset_s, -late_s, 1.1e-4);
    EXPECT_LT(clock->ate_m, 2e-4);
    EXPECT_LE(clock->ate_m, clock->ate_now_m);
    EXPECT_GE(clock->ate_now_m, 0.1 * std::abs(late_s)) << "about a metre a second";
  }
}

TEST(ClockOffset, OffsetBeyondTheLimitGivesNone) {
  const Trajectory truth = Along(200.0, 0.0);
  EXPECT_FALSE(FitClockOffset(Along(10.0, 0.2), truth, Alignment::kSe3, kMaxClockGap_ns, 0.05));
}

TEST(ClockOffset, StandingCameraHasNoOffset) {
  Trajectory truth = Along(200.0, 0.0);
  for (TrajectoryPose& pose : truth) pose.T_a_b = SE3();
  Trajectory estimate = Along(10.0, 0.0);
  for (TrajectoryPose& pose : estimate) pose.T_a_b = SE3();
  const auto clock = FitClockOffset(estimate, truth, Alignment::kSe3, kMaxClockGap_ns, 0.05);
  ASSERT_TRUE(clock);
  EXPECT_EQ(clock->offset_s, 0.0);
  EXPECT_EQ(clock->ate_m, 0.0);
}

TEST(ClockOffset, TooFewPosesGiveNone) {
  const Trajectory truth = Along(200.0, 0.0);
  EXPECT_FALSE(FitClockOffset({}, truth, Alignment::kSe3, kMaxClockGap_ns, 0.05));
  EXPECT_FALSE(FitClockOffset(Along(10.0, 0.0), {}, Alignment::kSe3, kMaxClockGap_ns, 0.05));
  EXPECT_FALSE(FitClockOffset(Along(10.0, 0.0, 0.25), truth, Alignment::kSe3, kMaxClockGap_ns, 0.05))
      << "of three poses the first has no truth before it";
  EXPECT_FALSE(FitClockOffset(Along(10.0, 0.0), truth, Alignment::kSe3, kMaxClockGap_ns, 0.0));
}

TEST(ClockOffset, TimesNearTheMaximumGiveNone) {
  Trajectory estimate = Along(10.0, 0.0);
  estimate.back().t_ns = std::numeric_limits<int64_t>::max();
  EXPECT_FALSE(FitClockOffset(estimate, Along(200.0, 0.0), Alignment::kSe3, kMaxClockGap_ns, 0.05));
}

}  // namespace
}  // namespace plslam::evaluate
