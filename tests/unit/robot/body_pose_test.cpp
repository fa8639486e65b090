// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/body_pose.h"

#include "core/geometry/body_frame.h"

#include <gtest/gtest.h>

#include <random>

namespace plslam::robot {
namespace {

RigCalibration Rig() {
  RigCalibration rig;
  rig.left.width_px = 376;
  rig.left.height_px = 240;
  rig.left.fx_px = rig.left.fy_px = 200.0;
  rig.left.cx_px = 187.5;
  rig.left.cy_px = 119.5;
  rig.right = rig.left;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0});
  rig.baseline_m = 0.1;
  return rig;
}

SE3 SomePose(std::mt19937_64& random, double size) {
  std::normal_distribution<double> normal(0.0, size);
  Vector6d x;
  for (double& value : x) value = normal(random);
  return SE3::Exp(x);
}

void ExpectNear(const SE3& a, const SE3& b) { EXPECT_LT((a.Inverse() * b).Log().norm(), 1e-9); }

TEST(BodyPose, CameraWithoutMountingLooksAlongX) {
  const SE3 T_b_c = BodyFromCamera(Rig());
  EXPECT_LT((T_b_c * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 0, 0)).norm(), 1e-9) << "ahead";
  EXPECT_LT((T_b_c * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, -1, 0)).norm(), 1e-9) << "right";
  EXPECT_LT((T_b_c * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(0, 0, -1)).norm(), 1e-9) << "down";
}

TEST(BodyPose, MountedCameraHasTheRigsTransform) {
  std::mt19937_64 random(1);
  const SE3 T_b_l = SomePose(random, 0.5);
  RigCalibration rig = Rig();
  rig.left.T_b_cam = T_b_l;
  rig.right.T_b_cam = T_b_l * rig.right.T_b_cam;
  ExpectNear(BodyFromCamera(rig), T_b_l);
}

// One metre ahead and a turn to the left, as the camera sees it: y of a camera points down.
TEST(BodyPose, AxesAndVelocityFollowRos) {
  CameraPose camera;
  const double turn = 0.1;
  const Eigen::Quaterniond left(Eigen::AngleAxisd(-turn, Eigen::Vector3d::UnitY()));
  camera.T_odom_c = camera.T_prev_c = SE3(left, {0.0, 0.0, 1.0});
  camera.dt_s = 0.5;
  const BodyPose body = ToBody(BodyFromCamera(Rig()), camera);
  EXPECT_LT((body.T_odom_b.translation() - Eigen::Vector3d(1, 0, 0)).norm(), 1e-9);
  EXPECT_LT((body.T_odom_b.rotation().toRotationMatrix() * Eigen::Vector3d(1, 0, 0) -
             Eigen::Vector3d(std::cos(turn), std::sin(turn), 0))
                .norm(),
            1e-9);
  ASSERT_TRUE(body.velocity);
  EXPECT_NEAR((*body.velocity)[0], 2.0, 0.01);
  EXPECT_NEAR((*body.velocity)[5], turn / 0.5, 1e-9);
  ExpectNear(SE3::Exp(0.5 * *body.velocity), body.T_odom_b);
  camera.dt_s.reset();
  EXPECT_FALSE(ToBody(BodyFromCamera(Rig()), camera).velocity);
}

TEST(BodyPose, MapOdomAndBodyAreOneChain) {
  std::mt19937_64 random(2);
  const SE3 T_b_c = SomePose(random, 1.0);
  CameraPose camera;
  camera.T_w_odom = SomePose(random, 1.0);
  camera.T_odom_c = SomePose(random, 1.0);
  const BodyPose body = ToBody(T_b_c, camera);
  ExpectNear(body.T_map_odom * body.T_odom_b, body.T_map_b);
  // A point of the map seen by the camera is where the body sees it.
  const Eigen::Vector3d p_c(0.3, -0.2, 4.0);
  const Eigen::Vector3d p_w = camera.T_w_odom * camera.T_odom_c * p_c;
  EXPECT_LT((body.T_map_b * (T_b_c * p_c) - ToMapFrame(T_b_c, p_w)).norm(), 1e-9);
}

// Errors drawn from the tracker's covariance, measured as ROS means them: position and rotation about the fixed axes.
TEST(BodyPose, TurnedCovarianceFitsTheErrors) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const SE3 T_b_c = SomePose(random, 1.0);
  CameraPose camera;
  camera.T_odom_c = SomePose(random, 2.0);
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = 1e-3 * normal(random);
  camera.covariance = A * A.transpose();
  const BodyPose body = ToBody(T_b_c, camera);
  constexpr int kSamples = 4000;
  double nees = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    Vector6d z;
    for (double& value : z) value = normal(random);
    CameraPose truth = camera;
    truth.T_odom_c = camera.T_odom_c * SE3::Exp(A * z);
    const SE3 T_true = ToBody(T_b_c, truth).T_odom_b;
    Vector6d error;
    error.head<3>() = T_true.translation() - body.T_odom_b.translation();
    error.tail<3>() =
        SE3(T_true.rotation() * body.T_odom_b.rotation().conjugate(), Eigen::Vector3d::Zero()).Log().tail<3>();
    nees += error.dot(body.covariance.ldlt().solve(error)) / kSamples;
  }
  // Six standard deviations of the mean of so many samples.
  EXPECT_NEAR(nees, 6.0, 6.0 * std::sqrt(12.0 / kSamples));
}

}  // namespace
}  // namespace plslam::robot
