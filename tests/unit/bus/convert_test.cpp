// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/convert.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/bus/messages/imu_channel.h"
#include "plslam/camera_t.hpp"
#include "plslam/imu_sample_t.hpp"
#include "plslam/imu_t.hpp"
#include "plslam/line_feature_t.hpp"
#include "plslam/point_feature_t.hpp"
#include "plslam/pose3_t.hpp"

namespace plslam::bus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

SE3 SomePose() {
  Vector6d x;
  x << 1.0, -2.0, 3.0, 0.4, -0.5, 2.6;
  return SE3::Exp(x);
}

RigCalibration SomeRig() {
  RigCalibration rig;
  rig.name = "test";
  rig.rate_hz = 20.0;
  rig.left.width_px = 752;
  rig.left.height_px = 480;
  rig.left.model = "radtan";
  rig.left.fx_px = 458.6;
  rig.left.fy_px = 457.3;
  rig.left.cx_px = 367.2;
  rig.left.cy_px = 248.4;
  rig.left.distortion = {-0.28, 0.07, 0.0002, 1e-5};
  rig.left.T_b_cam = SomePose();
  rig.right = rig.left;
  rig.right.model = "pinhole";
  rig.right.distortion.clear();
  rig.baseline_m = 0.11;
  return rig;
}

TEST(Convert, PoseSurvivesTheWire) {
  const SE3 T = SomePose();
  const auto back = FromMessage(ToMessage(T));
  ASSERT_TRUE(back);
  EXPECT_LT((back->matrix() - T.matrix()).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_GE(ToMessage(SE3(Eigen::Quaterniond(-0.5, 0.5, 0.5, 0.5), {0, 0, 0})).q_wxyz[0], 0.0);
}

TEST(Convert, RepeatedConversionKeepsTheBitsOfPoses) {
  for (int i = 0; i < 1000; ++i) {
    const pose3_t sent = ToMessage(SE3::Exp(Vector6d::Random()) * SE3::Exp(Vector6d::Random()));
    const auto T = FromMessage(sent);
    ASSERT_TRUE(T);
    const pose3_t again = ToMessage(*T);
    EXPECT_TRUE(std::equal(sent.q_wxyz, sent.q_wxyz + 4, again.q_wxyz)) << i;
    EXPECT_TRUE(std::equal(sent.position_m, sent.position_m + 3, again.position_m)) << i;
  }
}

TEST(Convert, InvalidPosesAreRefused) {
  for (const double bad : {kNan, kInf, -kInf, 2.0}) {
    for (int i = 0; i < 4; ++i) {
      pose3_t message = ToMessage(SomePose());
      message.q_wxyz[i] = bad;
      EXPECT_FALSE(FromMessage(message)) << bad;
    }
  }
  for (const double bad : {kNan, kInf, -kInf}) {
    pose3_t message = ToMessage(SomePose());
    message.position_m[1] = bad;
    EXPECT_FALSE(FromMessage(message));
  }
  EXPECT_FALSE(FromMessage(pose3_t{}));
}

TEST(Convert, CovarianceIsRowMajorAndChecked) {
  Matrix6d covariance = Matrix6d::Random();
  covariance = (covariance * covariance.transpose()).eval();
  double values[36];
  ToArray(covariance, values);
  EXPECT_EQ(values[6 * 2 + 4], covariance(2, 4));
  ASSERT_TRUE(FromArray(values));
  EXPECT_EQ(*FromArray(values), covariance);
  for (const double bad : {kNan, kInf, -1.0}) {
    double changed[36];
    ToArray(covariance, changed);
    changed[7] = bad;
    EXPECT_FALSE(FromArray(changed)) << bad;
  }
  values[1] += 1.0;
  EXPECT_FALSE(FromArray(values)) << "not symmetric";
}

TEST(Convert, DescriptorBitsKeepTheirOrder) {
  const Descriptor descriptor = {0x0123456789abcdef, 1, 0, 0xff00000000000000};
  uint8_t bytes[32];
  ToBytes(descriptor, bytes);
  EXPECT_EQ(bytes[0], 0xef);
  EXPECT_EQ(bytes[8], 1);
  EXPECT_EQ(bytes[31], 0xff);
  EXPECT_EQ(FromBytes(bytes), descriptor);
}

TEST(Convert, RigSurvivesTheWire) {
  const RigCalibration rig = SomeRig();
  const auto back = FromMessage(ToMessage(rig));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->name, rig.name);
  EXPECT_EQ(back->left.distortion, rig.left.distortion);
  EXPECT_EQ(back->left.fx_px, rig.left.fx_px);
  EXPECT_EQ(back->right.model, "pinhole");
  EXPECT_EQ(back->baseline_m, rig.baseline_m);
  EXPECT_EQ(back->kind, RigCalibration::Kind::kStereo);
}

TEST(Convert, ReadoutSurvivesTheWire) {
  RigCalibration rig = SomeRig();
  rig.left.readout_ms = rig.right.readout_ms = 25.3;
  camera_t message = ToMessage(rig);
  EXPECT_EQ(message.left.model, "radtan rolling 25.3");
  const auto back = FromMessage(message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->left.readout_ms, 25.3);
  EXPECT_EQ(back->right.model, "pinhole");
  for (const char* model : {"radtan rolling ", "radtan rolling -1", "radtan rolling nan", "radtan rolling 5x"}) {
    message.left.model = model;
    EXPECT_FALSE(FromMessage(message)) << model;
  }
}

TEST(Convert, ImuCalibrationSurvivesTheWire) {
  RigCalibration rig = SomeRig();
  EXPECT_EQ(ToMessage(rig).kind, "stereo") << "logs of earlier versions";
  const SE3 T_b_imu(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d(0.1, -0.2, 1.0 / 3.0));
  rig.imu = ImuCalibration{T_b_imu, {1.7e-4, 2e-5, 2e-3, 3e-3}, -0.0123, 200.0};
  camera_t message = ToMessage(rig);
  const auto back = FromMessage(message);
  ASSERT_TRUE(back && back->imu);
  EXPECT_LT((back->imu->T_b_imu.Inverse() * T_b_imu).Log().norm(), 1e-15);
  EXPECT_EQ(back->imu->noise.gyroscope_rad_s_sqrt_hz, 1.7e-4);
  EXPECT_EQ(back->imu->noise.accelerometer_walk_m_s3_sqrt_hz, 3e-3);
  EXPECT_EQ(back->imu->time_offset_s, -0.0123);
  EXPECT_EQ(back->imu->rate_hz, 200.0);
  for (const char* kind : {"stereo imu ", "stereo imu 1 2 3", "stereo imu 0 0 0 1 0 0 0 1 1 1 1 2 200",
                           "stereo imu 0 0 0 1 0 0 0 0 1 1 1 0 200", "stereo imu 0 0 0 1 0 0 0 1 1 1 1 0 nan",
                           "stereo imu 0 0 0 2 0 0 0 1 1 1 1 0 200", "stereo imu 0 0 0 1 0 0 0 1 1 1 1 0 200 7"}) {
    message.kind = kind;
    EXPECT_FALSE(FromMessage(message)) << kind;
  }
  message.kind = "stereo imu 0 0 0 1 0 0 0 1 1 1 1 0 200";
  EXPECT_TRUE(FromMessage(message));
}

TEST(Convert, ImuSamplesSurviveTheWire) {
  const ImuBatch batch{3, 9, false, {{4, {0.1, 0.2, 0.3}, {1.0, 2.0, 9.8}}, {8, {0.4, 0.5, 0.6}, {3.0, 4.0, 9.7}}}};
  imu_t message = ToMessage(batch);
  const auto back = FromMessage(message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->samples, batch.samples);
  EXPECT_EQ(back->from_ns, 3);
  EXPECT_EQ(back->t_ns, 9);
  EXPECT_FALSE(back->complete);
  message.samples[1].t_ns = 4;
  EXPECT_FALSE(FromMessage(message)) << "times must increase";
  message.samples[1].t_ns = 8;
  message.samples[0].rate_rad_s[2] = std::nan("");
  EXPECT_FALSE(FromMessage(message));
}

TEST(Convert, MasksSurviveTheWire) {
  RigCalibration rig = SomeRig();
  rig.left.mask = {{{{0.0F, 400.5F}, {751.0F, 380.0F}, {751.0F, 479.0F}}}, {{{1.0F, 2.0F}, {3.0F, 4.0F}}, true}};
  const auto back = FromMessage(ToMessage(rig));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->left.mask, rig.left.mask);
  EXPECT_TRUE(back->right.mask.empty());
}

TEST(Convert, LargestMasksFitOneDatagram) {
  // Triangles are the drawn shapes with the most bytes for their corners; specks of one pixel are the worst
  // of an image.
  for (const size_t n_corners : {1U, 3U}) {
    RigCalibration rig = SomeRig();
    MaskPolygon polygon;
    polygon.corners_px.assign(n_corners, {5.0F, 5.0F});
    rig.left.mask.assign(kMaxMaskCorners / n_corners, polygon);
    rig.right.mask = rig.left.mask;
    EXPECT_LE(RigBytes(ToMessage(rig)).size(), 59'000U) << n_corners;
    ASSERT_TRUE(FromMessage(ToMessage(rig)));
    rig.right.mask.insert(rig.right.mask.end(), 3, polygon);
    EXPECT_FALSE(FromMessage(ToMessage(rig))) << "more corners than a camera may have";
  }
}

TEST(Convert, InvalidRigsAreRefused) {
  const std::vector<std::function<void(camera_t&)>> faults = {
      [](camera_t& c) { c.kind = "mono"; },
      [](camera_t& c) { c.left.width_px = 0; },
      [](camera_t& c) { c.left.height_px = -480; },
      [](camera_t& c) { c.right.width_px = 1 << 30; },
      [](camera_t& c) { c.left.model = "fisheye"; },
      [](camera_t& c) { c.left.fx_px = 0.0; },
      [](camera_t& c) { c.left.fy_px = kNan; },
      [](camera_t& c) { c.left.cx_px = kInf; },
      [](camera_t& c) { c.left.distortion.pop_back(); },
      [](camera_t& c) { c.left.distortion[2] = kNan; },
      [](camera_t& c) { c.right.distortion.push_back(0.0); },
      [](camera_t& c) { c.baseline_m = 0.0; },
      [](camera_t& c) { c.rate_hz = kNan; },
      [](camera_t& c) { c.kind = "rgbd"; },
      [](camera_t& c) { c.left.T_b_cam.q_wxyz[0] = 7.0; },
      [](camera_t& c) {
        c.left.mask = {{1, 1, {{0.0F, static_cast<float>(kNan)}}}};
      },
      [](camera_t& c) {
        c.right.mask = {{0, 1, {{1e9F, 0.0F}}}};
      },
  };
  for (size_t i = 0; i < faults.size(); ++i) {
    camera_t message = ToMessage(SomeRig());
    faults[i](message);
    EXPECT_FALSE(FromMessage(message)) << "fault " << i;
  }
}

TEST(Convert, InvalidFeaturesAreRefused) {
  for (const float bad : {static_cast<float>(kNan), static_cast<float>(kInf)}) {
    for (const auto member :
         {&point_feature_t::u_px, &point_feature_t::v_px, &point_feature_t::disparity_px, &point_feature_t::sigma_px,
          &point_feature_t::sigma_disparity_px, &point_feature_t::angle_rad}) {
      point_feature_t point = ToMessage(StereoPoint(), -1, -1);
      ASSERT_TRUE(FromMessage(point));
      point.*member = bad;
      EXPECT_FALSE(FromMessage(point));
    }
    for (const auto member :
         {&line_feature_t::disparity_p_px, &line_feature_t::disparity_q_px, &line_feature_t::sigma_px,
          &line_feature_t::sigma_disparity_p_px, &line_feature_t::sigma_disparity_q_px}) {
      line_feature_t line = ToMessage(StereoLine(), -1, -1);
      ASSERT_TRUE(FromMessage(line));
      line.*member = bad;
      EXPECT_FALSE(FromMessage(line));
    }
  }
  point_feature_t point = ToMessage(StereoPoint(), -1, -1);
  point.octave = -1;
  EXPECT_FALSE(FromMessage(point));
  line_feature_t line = ToMessage(StereoLine(), -2, -1);
  EXPECT_FALSE(FromMessage(line));
}

}  // namespace
}  // namespace plslam::bus
