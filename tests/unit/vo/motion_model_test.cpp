#include "vo_process/motion_model.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

SE3 Forward(double metres) { return SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, 0.0, metres)); }

TEST(MotionModel, StandsBeforeItHasSeenMotion) {
  const MotionPrediction prediction = MotionModel(TrackingOptions()).Predict(0.1);
  EXPECT_LT(prediction.T_prev_c.Log().norm(), 1e-15);
}

TEST(MotionModel, GoesOnAtConstantVelocityWhateverTheInterval) {
  MotionModel model{TrackingOptions()};
  model.Observe(Forward(0.5), 0.1);
  EXPECT_NEAR(model.Predict(0.2).T_prev_c.translation().z(), 1.0, 1e-12);
  EXPECT_NEAR(model.Predict(0.05).T_prev_c.translation().z(), 0.25, 1e-12);
}

TEST(MotionModel, DoesNotExtrapolateAcrossALongGap) {
  MotionModel model{TrackingOptions()};
  model.Observe(Forward(0.5), 0.1);
  EXPECT_LE(model.Predict(7.0).T_prev_c.translation().z(), 1.0 + 1e-12);
}

TEST(MotionModel, UncertaintyIsThatOfTheLargestAcceleration) {
  TrackingOptions options;
  options.max_acceleration_m_s2 = 8.0;
  const MotionPrediction prediction = MotionModel(options).Predict(0.5);
  EXPECT_NEAR(prediction.covariance(0, 0), 1.0, 1e-12);
}

TEST(MotionModel, SlowsDownWhileLost) {
  MotionModel model{TrackingOptions()};
  model.Observe(Forward(1.0), 0.1);
  for (int i = 0; i < 40; ++i) model.Slow();
  EXPECT_LT(model.Predict(0.1).T_prev_c.translation().norm(), 1e-9);
}

TEST(MotionModel, IsTrustedToGoOnFromOneMeasuredFrameToTheNext) {
  MotionModel model{TrackingOptions()};
  EXPECT_FALSE(model.Predict(0.1).goes_on) << "never measured";
  model.Observe(Forward(1.0), 0.1);
  EXPECT_TRUE(model.Predict(0.1).goes_on);
  EXPECT_TRUE(model.Predict(0.2).goes_on) << "one frame is missing";
  EXPECT_FALSE(model.Predict(0.3).goes_on);
  model.Slow();
  EXPECT_FALSE(model.Predict(0.1).goes_on) << "lost";
  model.Observe(Forward(1.0), 0.1);
  EXPECT_TRUE(model.Predict(0.1).goes_on);
}

TEST(MotionModel, SaysNothingWhereTheCameraMayHaveTurnedAnywhereSince) {
  MotionModel model{TrackingOptions()};
  model.Observe(Forward(1.0), 5.0);
  EXPECT_FALSE(model.Predict(5.0).goes_on);
}

}  // namespace
}  // namespace plslam
