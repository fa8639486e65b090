// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/se3.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

Vector6d Tangent(double scale) {
  Vector6d x;
  x << 0.3, -1.2, 0.7, 0.4, -0.9, 0.2;
  return scale * x;
}

TEST(SE3, LogInvertsExpFromTinyToLargeAngles) {
  for (const double scale : {0.0, 1e-12, 1e-7, 1e-4, 1e-2, 1.0, 2.5}) {
    const Vector6d x = Tangent(scale);
    EXPECT_LT((SE3::Exp(x).Log() - x).norm(), 1e-9 * (1.0 + x.norm())) << "scale " << scale;
  }
}

TEST(SE3, LogOfHalfTurnHasAnglePi) {
  const SE3 T(Eigen::Quaterniond(0.0, 0.0, 1.0, 0.0), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_NEAR(T.Log().tail<3>().norm(), M_PI, 1e-12);
}

TEST(SE3, AdjointMovesAPerturbationToTheOtherSide) {
  const SE3 T = SE3::Exp(Tangent(0.8));
  const Vector6d x = Tangent(-0.05);
  const SE3 right = T * SE3::Exp(x);
  const SE3 left = SE3::Exp(T.Adjoint() * x) * T;
  EXPECT_LT((right.matrix() - left.matrix()).norm(), 1e-12);
}

TEST(SE3, InverseUndoes) {
  const SE3 T = SE3::Exp(Tangent(1.3));
  EXPECT_LT(((T * T.Inverse()).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-12);
}

TEST(SE3, CovarianceOfTheInverseAsByPerturbing) {
  const SE3 T = SE3::Exp(Tangent(0.7));
  Matrix6d covariance = Matrix6d::Zero();
  constexpr double kStep = 1e-6;
  Matrix6d J;
  for (int k = 0; k < 6; ++k) {
    const Vector6d x = kStep * Vector6d::Unit(k);
    J.col(k) = (T * (T * SE3::Exp(x)).Inverse()).Log() / kStep;
    covariance(k, k) = 0.1 * (k + 1);
  }
  const Matrix6d expected = J * covariance * J.transpose();
  EXPECT_LT((InverseCovariance(T, covariance) - expected).norm(), 1e-4 * expected.norm());
}

TEST(SE3, ComposedCovarianceMatchesNumericPropagation) {
  const SE3 T_a_b = SE3::Exp(Tangent(0.5));
  const SE3 T_b_c = SE3::Exp(Tangent(-0.9));
  Matrix6d cov_ab = Matrix6d::Identity() * 0.01;
  cov_ab(0, 3) = cov_ab(3, 0) = 0.002;
  const Matrix6d cov_bc = Matrix6d::Identity() * 0.02;
  Matrix6d J;
  for (int i = 0; i < 6; ++i) {
    const Vector6d step = 1e-6 * Vector6d::Unit(i);
    J.col(i) = ((T_a_b * T_b_c).Inverse() * (T_a_b * SE3::Exp(step) * T_b_c)).Log() / 1e-6;
  }
  const Matrix6d expected = J * cov_ab * J.transpose() + cov_bc;
  EXPECT_LT((ComposeCovariance(cov_ab, T_b_c, cov_bc) - expected).norm(), 1e-6);
}

}  // namespace
}  // namespace plslam
