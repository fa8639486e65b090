// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "vo_process/tracking/motion/keyframe_policy.h"

namespace plslam::vo {
namespace {

KeyframeCandidate Standing() {
  KeyframeCandidate candidate;
  candidate.covariance = 1e-8 * Matrix6d::Identity();
  candidate.tracked_from_keyframe = 200;
  candidate.median_depth_m = 4.0;
  return candidate;
}

KeyframeCandidate Moved(double metres) {
  KeyframeCandidate candidate = Standing();
  candidate.T_kf_c = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(metres, 0.0, 0.0));
  return candidate;
}

KeyframeReason Second(const KeyframeCandidate& candidate) {
  KeyframePolicy policy{KeyframeOptions()};
  policy.Decide(Standing());
  return policy.Decide(candidate).reason;
}

TEST(KeyframePolicy, StandingCameraMakesNone) {
  KeyframePolicy policy{KeyframeOptions()};
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(policy.Decide(Standing()).reason, KeyframeReason::kNone) << "frame " << i;
}

TEST(KeyframePolicy, SmallMotionAloneIsNoReason) { EXPECT_EQ(Second(Moved(0.2)), KeyframeReason::kNone); }

TEST(KeyframePolicy, RatioOfFirstFrameIsOne) {
  KeyframePolicy policy{KeyframeOptions()};
  EXPECT_NEAR(policy.Decide(Standing()).entropy_ratio, 1.0, 1e-12);
}

TEST(KeyframePolicy, GrownUncertaintyIsAReason) {
  KeyframeCandidate candidate = Moved(0.2);
  candidate.covariance *= 100.0;
  EXPECT_EQ(Second(candidate), KeyframeReason::kEntropy);
}

TEST(KeyframePolicy, LostLandmarksAreAReason) {
  KeyframeCandidate candidate = Moved(0.2);
  candidate.tracked_from_keyframe = 40;
  EXPECT_EQ(Second(candidate), KeyframeReason::kTracked);
}

TEST(KeyframePolicy, LargeBaselineIsAReason) { EXPECT_EQ(Second(Moved(2.0)), KeyframeReason::kBaseline); }

TEST(KeyframePolicy, RotationIsAReason) {
  KeyframeCandidate candidate = Standing();
  candidate.T_kf_c = SE3(ExpSO3(Eigen::Vector3d(0.0, 0.4, 0.0)), Eigen::Vector3d::Zero());
  EXPECT_EQ(Second(candidate), KeyframeReason::kRotation);
}

TEST(KeyframePolicy, MappedViewNeedsNoneForMotionAlone) {
  KeyframeCandidate candidate = Moved(2.0);
  candidate.T_kf_c = candidate.T_kf_c * SE3(ExpSO3(Eigen::Vector3d(0.0, 0.4, 0.0)), Eigen::Vector3d::Zero());
  candidate.known_share = KeyframeOptions().known_share;
  EXPECT_EQ(Second(candidate), KeyframeReason::kNone);
  KeyframePolicy policy{KeyframeOptions()};
  policy.Decide(Standing());
  for (int i = 0; i < 2 * KeyframeOptions().max_frames; ++i) {
    ASSERT_EQ(policy.Decide(candidate).reason, KeyframeReason::kNone) << "frame " << i;
  }
  KeyframeCandidate unsure = candidate;
  unsure.covariance *= 100.0;
  EXPECT_EQ(Second(unsure), KeyframeReason::kEntropy);
  KeyframeCandidate elsewhere = candidate;
  elsewhere.tracked_from_keyframe = 40;
  EXPECT_EQ(Second(elsewhere), KeyframeReason::kTracked);
  candidate.known_share -= 0.01;
  EXPECT_EQ(Second(candidate), KeyframeReason::kBaseline);
}

TEST(KeyframePolicy, AgeIsAReasonOnlyForACameraThatHasMoved) {
  KeyframeOptions options;
  options.max_frames = 5;
  KeyframePolicy policy(options);
  for (int i = 0; i < 20; ++i) policy.Decide(Standing());
  EXPECT_EQ(policy.Decide(Moved(0.2)).reason, KeyframeReason::kAge);
}

TEST(KeyframePolicy, UnknownDepthDoesNotDivideByZero) {
  KeyframeCandidate candidate = Moved(0.2);
  candidate.median_depth_m = 0.0;
  EXPECT_EQ(Second(candidate), KeyframeReason::kBaseline);
}

}  // namespace

namespace {

TEST(MotionEntropy, EqualsTheDeterminantFormula) {
  Matrix6d A = Matrix6d::Identity();
  A(0, 1) = 0.3;
  A(4, 2) = -0.5;
  const Matrix6d covariance = A * A.transpose();
  const double expected = 3.0 * (1.0 + std::log(2.0 * std::numbers::pi)) + 0.5 * std::log(covariance.determinant());
  EXPECT_NEAR(*MotionEntropy(covariance), expected, 1e-10);
}

TEST(MotionEntropy, TinyDeterminants) {
  // The determinant would be 1e-360.
  EXPECT_NEAR(*MotionEntropy(1e-60 * Matrix6d::Identity()), 8.5136 + 3.0 * std::log(1e-60), 1e-3);
}

TEST(MotionEntropy, SingularHasNone) {
  EXPECT_FALSE(MotionEntropy(Matrix6d::Zero()));
  EXPECT_FALSE(MotionEntropy(Matrix6d::Ones()));
  EXPECT_FALSE(MotionEntropy(-Matrix6d::Identity()));
  EXPECT_FALSE(MotionEntropy(std::nan("") * Matrix6d::Identity()));
  EXPECT_FALSE(EntropyRatio(Matrix6d::Identity(), Matrix6d::Zero()));
}

TEST(EntropyRatio, FallsAsUncertaintyGrowsForEitherSign) {
  for (const double first : {1e-8, 1e-5, 1e-3, 1.0, 1e3}) {
    double previous = *EntropyRatio(first * Matrix6d::Identity(), 0.5 * first * Matrix6d::Identity());
    EXPECT_GT(previous, 1.0) << "first variance " << first;
    EXPECT_NEAR(*EntropyRatio(first * Matrix6d::Identity(), first * Matrix6d::Identity()), 1.0, 1e-12);
    for (double factor = 1.5; factor < 1e4; factor *= 2.0) {
      const double ratio = *EntropyRatio(first * Matrix6d::Identity(), factor * first * Matrix6d::Identity());
      EXPECT_LT(ratio, previous) << "first variance " << first << " factor " << factor;
      previous = ratio;
    }
  }
}

}  // namespace
}  // namespace plslam::vo
