// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/rectification.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/geometry/test_rigs.h"
#include "tests/unit/geometry/turned_rig.h"

namespace plslam {
namespace {

using testing::HasSubstr;

// Pixel of a point given in the camera as calibrated, by the definition of the models.
Eigen::Vector2d ProjectRaw(const CameraCalibration& c, const Eigen::Vector3d& p) {
  const Eigen::Vector2d xy = *Distortion(c).Distort(p.head<2>() / p.z());
  return {c.fx_px * xy.x() + c.cx_px, c.fy_px * xy.y() + c.cy_px};
}

std::string MessageOf(const RigCalibration& rig) {
  try {
    Rectify(rig);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

// The whole chain: a point in space, seen by both raw cameras, is found by both maps at its ideal stereo measurement.
TEST(Rectify, RawPixelsOfAnyPointLieOnOneRow) {
  for (const RigCalibration& rig : {test::EurocRig(), test::FisheyeRig()}) {
    SCOPED_TRACE(rig.name);
    const Rectification r = Rectify(rig);
    const SE3 T_r_l = rig.right.T_b_cam.Inverse() * rig.left.T_b_cam;
    for (const Eigen::Vector3d& p_c : {Eigen::Vector3d(0.5, 0.3, 3.0), Eigen::Vector3d(-1.0, 0.5, 2.0),
                                       Eigen::Vector3d(0.0, -1.0, 5.0), Eigen::Vector3d(3.0, 2.0, 20.0)}) {
      const Eigen::Vector3d p_l = r.q_l_c * p_c;
      const Eigen::Vector3d uvd = r.camera.ProjectStereo(p_c);
      const auto left = r.left.RawPixel(r.camera, uvd.head<2>());
      const auto right = r.right.RawPixel(r.camera, {uvd.x() - uvd.z(), uvd.y()});
      ASSERT_TRUE(left && right);
      EXPECT_LT((*left - ProjectRaw(rig.left, p_l)).norm(), 1e-6);
      EXPECT_LT((*right - ProjectRaw(rig.right, T_r_l * p_l)).norm(), 1e-6);
    }
  }
}

TEST(Rectify, RectifiedPointInvertsRawPixel) {
  const Rectification r = Rectify(test::FisheyeRig());
  const Eigen::Vector2d px(100.0, 400.0);
  const auto point = r.right.RectifiedPoint(*r.right.RawPixel(r.camera, px));
  ASSERT_TRUE(point);
  EXPECT_LT((r.camera.Project(point->homogeneous()) - px).norm(), 1e-6);
}

TEST(Rectify, EurocKeepsItsViewAndResolution) {
  const Rectification r = Rectify(test::EurocRig());
  EXPECT_FALSE(r.identity);
  EXPECT_NEAR(r.camera.baseline_m, 0.110078, 1e-5);
  EXPECT_GT(r.camera.f_px, 420.0);
  EXPECT_LT(r.camera.f_px, 460.0);
  EXPECT_LT(r.q_l_c.angularDistance(Eigen::Quaterniond::Identity()), 0.02);
}

TEST(Rectify, FisheyeIsLimitedToAHundredDegrees) {
  const StereoCamera c = Rectify(test::FisheyeRig()).camera;
  const double fov_deg = 2.0 * std::atan(0.5 * c.width_px / c.f_px) * 57.29578;
  EXPECT_GT(fov_deg, 80.0);
  EXPECT_LT(fov_deg, 101.0);
}

// The turn is shared: both cameras are rotated by about the same angle.
TEST(Rectify, RotationIsSplitEvenly) {
  RigCalibration rig = test::IdealRig();
  rig.right.T_b_cam = SE3(ExpSO3({0.1, 0.0, 0.0}), {0.1, 0.0, 0.0});
  const Rectification r = Rectify(rig);
  EXPECT_NEAR(r.q_l_c.angularDistance(Eigen::Quaterniond::Identity()), 0.05, 1e-6);
}

TEST(Rectify, IdealPairIsUntouched) {
  for (const double noise : {0.0, 1e-9}) {
    RigCalibration rig = test::IdealRig();
    rig.right.T_b_cam = SE3(ExpSO3({noise, -noise, noise}), {0.1, noise * 0.1, 0.0});
    const Rectification r = Rectify(rig);
    EXPECT_TRUE(r.identity);
    EXPECT_EQ(r.camera.f_px, 500.0);
    EXPECT_EQ(r.camera.cx_px, 318.5);
    EXPECT_EQ(r.q_l_c.coeffs(), Eigen::Quaterniond::Identity().coeffs());
  }
  RigCalibration toed = test::IdealRig();
  toed.right.T_b_cam = SE3(ExpSO3({0.0, 0.001, 0.0}), {0.1, 0.0, 0.0});
  EXPECT_FALSE(Rectify(toed).identity);
}

TEST(Rectify, PairOneAboveTheOtherIsTurned) {
  for (const RigCalibration& rig : {test::IdealRig(), test::EurocRig(), test::FisheyeRig()}) {
    for (const int quarters : {1, 3}) {
      SCOPED_TRACE(rig.name + " " + std::to_string(quarters));
      const RigCalibration turned = test::TurnedClockwise(rig, quarters);
      const Rectification expected = Rectify(rig), r = Rectify(turned);
      EXPECT_EQ(r.camera.width_px, rig.left.width_px);
      EXPECT_EQ(r.camera.height_px, rig.left.height_px);
      EXPECT_NEAR(r.camera.f_px, expected.camera.f_px, 1e-6);
      EXPECT_NEAR(r.camera.cx_px, expected.camera.cx_px, 1e-6);
      EXPECT_NEAR(r.camera.cy_px, expected.camera.cy_px, 1e-6);
      EXPECT_NEAR(r.camera.baseline_m, expected.camera.baseline_m, 1e-9);
      const Eigen::Quaterniond q_l_turned((rig.left.T_b_cam.Inverse() * turned.left.T_b_cam).rotation());
      EXPECT_NEAR((q_l_turned * r.q_l_c).angularDistance(expected.q_l_c), 0.0, 1e-6);
    }
  }
}

TEST(Rectify, RgbdOnlyLosesItsDistortion) {
  const Rectification r = Rectify(test::RgbdRig());
  EXPECT_FALSE(r.identity);
  EXPECT_EQ(r.camera.baseline_m, 0.08);
  EXPECT_NEAR(r.q_l_c.angularDistance(Eigen::Quaterniond::Identity()), 0.0, 1e-12);
  EXPECT_NEAR(r.camera.f_px, 517.0, 30.0);
}

TEST(Rectify, UnusableRigsAreNamed) {
  RigCalibration rig = test::IdealRig();
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.1});
  EXPECT_THAT(MessageOf(rig), HasSubstr("beside each other"));
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {-0.1, 0.0, 0.0});
  EXPECT_THAT(MessageOf(rig), HasSubstr("exchanged"));
  rig.right.T_b_cam = SE3();
  EXPECT_THAT(MessageOf(rig), HasSubstr("same position"));
  rig.right.T_b_cam = SE3(ExpSO3({0.0, 1.5, 0.0}), {0.1, 0.0, 0.0});
  EXPECT_THAT(MessageOf(rig), HasSubstr("apart"));
  rig = test::IdealRig();
  rig.right.width_px = 320;
  EXPECT_THAT(MessageOf(rig), HasSubstr("320x480"));
  rig = test::IdealRig();
  rig.left.fx_px = std::nan("");
  EXPECT_THAT(MessageOf(rig), HasSubstr("left intrinsics"));
  rig = test::RgbdRig();
  rig.baseline_m = 0.0;
  EXPECT_THAT(MessageOf(rig), HasSubstr("virtual baseline"));
}

}  // namespace
}  // namespace plslam
