// SPDX-License-Identifier: BSD-3-Clause
#include "core/optim/bundle/camera_view.h"

#include <gtest/gtest.h>

#include "tests/unit/optim/bundle_world.h"

namespace plslam {
namespace {

AdjustedPose SomePose() {
  Vector6d start;
  start << 0.4, -0.2, 1.0, 0.3, -0.5, 0.2;
  AdjustedPose pose(SE3::Exp(start), 0);
  pose.x << 0.1, 0.2, -0.3, 0.5, -0.9, 0.4;
  pose.Update();
  return pose;
}

TEST(AdjustedPose, UntouchedComesBackBitForBit) {
  const SE3 T_w_c(Eigen::Quaterniond(0.3, -0.2, 0.7, 0.1), Eigen::Vector3d(1.0, 2.0, 3.0));
  const SE3 same = AdjustedPose(T_w_c, 0).T_w_c();
  EXPECT_EQ(same.rotation().coeffs(), T_w_c.rotation().coeffs());
  EXPECT_EQ(same.translation(), T_w_c.translation());
}

TEST(AdjustedPose, ViewFollowsParameters) {
  const AdjustedPose pose = SomePose();
  const Eigen::Vector3d p_w(0.3, 4.0, -2.0);
  EXPECT_LT((pose.view.ToCamera(p_w) - pose.T_w_c().Inverse() * p_w).norm(), 1e-12);
}

// The covariance of x, carried to the right perturbation, by numeric derivatives.
TEST(AdjustedPose, CovarianceOfRightPerturbation) {
  const AdjustedPose pose = SomePose();
  Matrix6d J;
  for (int i = 0; i < 6; ++i) {
    AdjustedPose moved = pose;
    moved.x(i) += 1e-6;
    J.col(i) = (pose.T_w_c().Inverse() * moved.T_w_c()).Log() / 1e-6;
  }
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i) = std::sin(7.0 * i);
  const Matrix6d covariance = A * A.transpose();
  const Matrix6d expected = J * covariance * J.transpose();
  EXPECT_LT((pose.RightCovariance(covariance) - expected).norm(), 1e-5 * expected.norm());
}

}  // namespace
}  // namespace plslam
