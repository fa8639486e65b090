// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/relative_error.h"

#include <gtest/gtest.h>

#include "core/accuracy/consistency.h"
#include "tests/unit/evaluate/pairs.h"
#include "tools/evaluate/keyframe_error.h"

namespace plslam {
namespace {

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

}  // namespace
}  // namespace plslam
