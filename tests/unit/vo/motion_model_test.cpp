// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/motion_model.h"

#include <cmath>

#include <gtest/gtest.h>

namespace plslam::vo {
namespace {

const Matrix6d kExact = Matrix6d::Zero();

SE3 Forward(double metres) { return SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, 0.0, metres)); }

TEST(MotionModel, PredictsNoMotionAtFirst) {
  const MotionPrediction prediction = MotionModel().Predict(0.1);
  EXPECT_LT(prediction.T_prev_c.Log().norm(), 1e-15);
}

TEST(MotionModel, ConstantVelocityForAnyInterval) {
  MotionModel model;
  model.Observe(Forward(0.5), 0.1, kExact);
  EXPECT_NEAR(model.Predict(0.2).T_prev_c.translation().z(), 1.0, 1e-12);
  EXPECT_NEAR(model.Predict(0.05).T_prev_c.translation().z(), 0.25, 1e-12);
}

TEST(MotionModel, DoesNotExtrapolateAcrossALongGap) {
  MotionModel model;
  model.Observe(Forward(0.5), 0.1, kExact);
  EXPECT_LE(model.Predict(7.0).T_prev_c.translation().z(), 1.0 + 1e-12);
}

TEST(MotionModel, UncertaintyMatchesTheLargestAcceleration) {
  MotionModel model;
  model.Observe(SE3(), 0.5, kExact);
  EXPECT_NEAR(model.Predict(0.5).covariance(0, 0), 1.25 * 1.25, 1e-12);
}

TEST(MotionModel, AnySpeedBeforeTheFirstMotion) {
  MotionModel model;
  EXPECT_GT(std::sqrt(model.Predict(0.1).covariance(2, 2)), 2.0) << "m: a car on a motorway";
  EXPECT_GT(std::sqrt(model.Predict(0.1).covariance(4, 4)), 0.1) << "rad: a hand that turns";
}

TEST(MotionModel, SlowsDownWhileLost) {
  MotionModel model;
  model.Observe(Forward(1.0), 0.1, kExact);
  for (int i = 0; i < 40; ++i) model.Slow(0.1);
  EXPECT_LT(model.Predict(0.1).T_prev_c.translation().norm(), 1e-9);
}

TEST(MotionModel, ContinuesOnlyBetweenMeasuredFrames) {
  MotionModel model;
  EXPECT_FALSE(model.Predict(0.1).is_reliable) << "never measured";
  model.Observe(Forward(1.0), 0.1, kExact);
  EXPECT_TRUE(model.Predict(0.1).is_reliable);
  EXPECT_TRUE(model.Predict(0.2).is_reliable) << "one frame is missing";
  EXPECT_FALSE(model.Predict(0.3).is_reliable);
  model.Slow(0.1);
  EXPECT_FALSE(model.Predict(0.1).is_reliable) << "lost";
  model.Observe(Forward(1.0), 0.1, kExact);
  EXPECT_TRUE(model.Predict(0.1).is_reliable);
}

TEST(MotionModel, NoPredictionAcrossALongGap) {
  MotionModel model;
  model.Observe(Forward(1.0), 5.0, kExact);
  EXPECT_FALSE(model.Predict(5.0).is_reliable);
  EXPECT_FALSE(model.Predict(5.0).is_near);
}

TEST(MotionModel, IsNearAfterAFewMissingFrames) {
  MotionModel model;
  model.Observe(Forward(0.005), 0.005, kExact);
  EXPECT_FALSE(model.Predict(0.02).is_reliable);
  EXPECT_TRUE(model.Predict(0.02).is_near);
  model.Slow(0.005);
  EXPECT_FALSE(model.Predict(0.005).is_near) << "lost";
}

// At 200 Hz an acceleration contributes a tenth of a millimetre; the velocity was measured less exactly.
TEST(MotionModel, NotMoreCertainThanTheMeasuredMotion) {
  MotionModel model;
  model.Observe(Forward(0.005), 0.005, 1e-6 * Matrix6d::Identity());
  EXPECT_GT(model.Predict(0.005).covariance(0, 0), 1e-6);
  EXPECT_GT(model.Predict(0.010).covariance(0, 0), 4e-6);
}

// The uncertainty of a lost camera's motion does not depend on the number of lost frames, and includes the distance by
// which the prediction falls behind constant speed.
TEST(MotionModel, UncertaintiesOfLostFramesAddUpToThatOfTheGap) {
  for (const int n : {1, 10, 100}) {
    MotionModel model;
    model.Observe(Forward(0.05), 0.05, kExact);
    const double dt_s = 0.5 / n;
    double variance = 0.0;
    double predicted_m = 0.0;
    for (int i = 0; i < n; ++i) {
      const MotionPrediction prediction = model.Predict(dt_s);
      variance += prediction.covariance(2, 2);
      predicted_m += prediction.T_prev_c.translation().z();
      model.Slow(dt_s);
    }
    const double accelerated_m = 0.5 * 10.0 * 0.25;
    const double behind_m = 0.5 - predicted_m;
    EXPECT_NEAR(variance, accelerated_m * accelerated_m + behind_m * behind_m, 1e-9) << n << " frames";
  }
}

}  // namespace
}  // namespace plslam::vo
