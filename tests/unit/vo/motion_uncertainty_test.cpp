// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/motion_uncertainty.h"

#include <gtest/gtest.h>

#include <random>

namespace plslam::vo {
namespace {

constexpr SessionId kSession = 7;

Matrix6d Claimed() {
  Vector6d sigma;
  sigma << 0.001, 0.001, 0.002, 2e-4, 2e-4, 2e-4;
  return sigma.cwiseAbs2().asDiagonal();
}

// Returns keyframes 0.3 m apart, which the map has moved by `factor` times the standard deviations of the tracker's
// motions.
Map MovedMap(double factor, int keyframes) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const SE3 step = SE3::Exp((Vector6d() << 0.0, 0.0, 0.3, 0.0, 0.02, 0.0).finished());
  Map map;
  MapKeyframe keyframe;
  keyframe.name.session = kSession;
  keyframe.T_prevkf_kf = step;
  for (int i = 0; i < keyframes; ++i) {
    Vector6d x;
    for (double& value : x) value = normal(random);
    keyframe.name.number = i;
    keyframe.id = KeyframeId(keyframe.name.number);
    keyframe.previous_id = i - 1;
    if (i > 0) {
      keyframe.relative_covariance = Claimed();
      keyframe.T_w_kf = keyframe.T_w_kf * step * SE3::Exp(factor * x.cwiseProduct(Claimed().diagonal().cwiseSqrt()));
    }
    map.Put(keyframe);
  }
  return map;
}

double LearnedScale(double factor, SessionId session = kSession) {
  MotionUncertainty uncertainty;
  uncertainty.Learn(MovedMap(factor, 40), session);
  return uncertainty.variance_scale();
}

const SE3 kStep = SE3::Exp((Vector6d() << 0.0, 0.0, 0.1, 0.0, 0.0, 0.0).finished());

TEST(MotionUncertainty, LearnsHowFarAdjustmentMovesTheTrackersMotions) {
  EXPECT_NEAR(LearnedScale(1.0), 1.0, 0.3);
  EXPECT_NEAR(LearnedScale(3.0), 9.0, 2.5);
  EXPECT_NEAR(LearnedScale(0.5), 0.3, 0.1);
}

TEST(MotionUncertainty, IsBounded) {
  EXPECT_LE(LearnedScale(1e6), 25.0);
  EXPECT_GE(LearnedScale(0.0), 0.04);
}

TEST(MotionUncertainty, LearnsNothingOfOtherSessions) {
  EXPECT_EQ(LearnedScale(3.0, SessionId(kSession.value + 1)), 1.0);
}

TEST(MotionUncertainty, OneOutlierMotionDoesNotChangeTheMean) {
  Map map = MovedMap(0.5, 40);
  MapKeyframe keyframe = *map.FindKeyframe(39);
  keyframe.T_w_kf = keyframe.T_w_kf * SE3::Exp(Vector6d::Constant(1.0));
  map.Put(keyframe);
  MotionUncertainty uncertainty;
  uncertainty.Learn(map, kSession);
  EXPECT_LT(uncertainty.variance_scale(), 2.0);
}

TEST(MotionUncertainty, SmallAdjustmentsAddNoDrift) {
  MotionUncertainty uncertainty;
  uncertainty.Learn(MovedMap(0.3, 40), kSession);
  const Matrix6d covariance = uncertainty.Of(kStep, Claimed(), true);
  EXPECT_LT((covariance - uncertainty.variance_scale() * Claimed()).norm(), 1e-15);
}

// Over twenty frames, added up as independent, the drift alone is half a percent of the path.
TEST(MotionUncertainty, DriftOverTwentyFramesIsHalfAPercent) {
  MotionUncertainty uncertainty;
  uncertainty.Learn(MovedMap(3.0, 40), kSession);
  Matrix6d sum = Matrix6d::Zero();
  for (int i = 0; i < 20; ++i) sum = ComposeCovariance(sum, kStep, uncertainty.Of(kStep, Matrix6d::Zero(), true));
  EXPECT_NEAR(std::sqrt(sum(2, 2)), 0.005 * 2.0, 1e-6);
}

TEST(MotionUncertainty, UnmeasuredMotionIsNotMadeMoreCertain) {
  MotionUncertainty uncertainty;
  uncertainty.Learn(MovedMap(0.0, 40), kSession);
  EXPECT_EQ(uncertainty.Of(kStep, Claimed(), false), Claimed());
}

}  // namespace
}  // namespace plslam::vo
