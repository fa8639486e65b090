// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/keyframe_policy.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/LU>

namespace plslam::vo {
namespace {

TEST(MotionEntropy, EqualsDeterminantWhereThatIsSafe) {
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

TEST(EntropyRatio, FallsAsUncertaintyGrowsWhateverTheSign) {
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
