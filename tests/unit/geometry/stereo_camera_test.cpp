// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/stereo_camera.h"

#include <gtest/gtest.h>

#include "core/geometry/triangulation.h"

namespace plslam {
namespace {

const StereoCamera kCamera{400.0, 320.0, 240.0, 0.1, 640, 480};

TEST(StereoCamera, BackprojectInvertsProject) {
  const Eigen::Vector3d p(0.7, -0.4, 3.2);
  EXPECT_LT((kCamera.Backproject(kCamera.ProjectStereo(p)) - p).norm(), 1e-12);
}

TEST(StereoCamera, JacobianMatchesDifferences) {
  const Eigen::Vector3d p(0.7, -0.4, 3.2);
  const Eigen::Matrix3d J = kCamera.ProjectStereoJacobian(p);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(i);
    const Eigen::Vector3d numeric = (kCamera.ProjectStereo(p + step) - kCamera.ProjectStereo(p - step)) / 2e-6;
    EXPECT_LT((J.col(i) - numeric).norm(), 1e-5) << "column " << i;
  }
}

TEST(StereoCamera, BackprojectCovarianceIsInverseOfInformation) {
  const Eigen::Vector3d p(0.7, -0.4, 3.2);
  const Eigen::Matrix3d J = kCamera.ProjectStereoJacobian(p);
  const Eigen::Matrix3d information = J.transpose() * Eigen::Vector3d(1.0, 1.0, 4.0).asDiagonal() * J;
  const Eigen::Matrix3d covariance = kCamera.BackprojectCovariance(kCamera.ProjectStereo(p), 1.0, 0.5);
  EXPECT_LT((covariance * information - Eigen::Matrix3d::Identity()).norm(), 1e-9);
}

TEST(LineThrough, ProductIsSignedDistance) {
  const Eigen::Vector3d l = LineThrough({Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(5.0, 1.0)});
  EXPECT_NEAR(l.dot(Eigen::Vector3d(100.0, 1.0, 1.0)), 0.0, 1e-12);
  EXPECT_NEAR(std::abs(l.dot(Eigen::Vector3d(3.0, 4.0, 1.0))), 3.0, 1e-12);
}

}  // namespace
}  // namespace plslam
