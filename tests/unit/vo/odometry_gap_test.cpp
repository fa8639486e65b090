// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/feature_world.h"
#include "tests/unit/vo/feature_path.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

using test::FeatureWorld;
using test::kFrame_ns;
using test::PathAt;

double Length_m(const LineLandmark& line) { return (line.segment_odom.q - line.segment_odom.p).norm(); }

// The camera moves on in the dark, in an unknown direction.
TEST(OdometryGaps, UncertaintyAcrossALossGrowsWithTheGap) {
  const FeatureWorld before({300, 60}, 9);
  const FeatureWorld after({300, 60}, 10);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 10; ++i) odometry.Track(i * kFrame_ns, before.Observe(PathAt(i), 0.3, i));
  const SE3 T_w_kf = PathAt(9);
  for (int i = 10; i < 30; ++i) odometry.Track(i * kFrame_ns, {});
  EXPECT_EQ(odometry.Track(30 * kFrame_ns, after.Observe(PathAt(30), 0.3, 30)).state, TrackingState::kLost);
  const OdometryResult back = odometry.Track(31 * kFrame_ns, after.Observe(PathAt(31), 0.3, 31));
  ASSERT_EQ(back.state, TrackingState::kRecovered);
  ASSERT_TRUE(back.keyframe);
  const Vector6d error = ((T_w_kf.Inverse() * PathAt(31)).Inverse() * back.keyframe->T_prevkf_kf).Log();
  EXPECT_LT(error.dot(back.keyframe->covariance.ldlt().solve(error)), 6.0);
}

// A session that begins on a motorway, and whose second frame has no features: the camera may be anywhere ahead.
TEST(OdometryGaps, LossBeforeAnyMotionAllowsAnySpeed) {
  constexpr double kMotorway_m_s = 30.0;
  const FeatureWorld before({300, 60}, 9);
  const FeatureWorld after({300, 60}, 10);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  odometry.Track(0, before.Observe(SE3(), 0.3, 0));
  odometry.Track(kFrame_ns, {});
  odometry.Track(2 * kFrame_ns, after.Observe(SE3(), 0.3, 1));
  const OdometryResult back = odometry.Track(3 * kFrame_ns, after.Observe(SE3(), 0.3, 2));
  ASSERT_EQ(back.state, TrackingState::kRecovered);
  ASSERT_TRUE(back.keyframe);
  EXPECT_GT(std::sqrt(back.keyframe->covariance(2, 2)), kMotorway_m_s * 2e-9 * kFrame_ns);
}

// The predicted pose of a lost camera follows its last known motion.
TEST(OdometryGaps, MotionIsKeptAcrossDarkFrames) {
  const FeatureWorld world({300, 60}, 9);
  const auto at = [](int i) { return SE3(Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.08 * i}); };
  for (const int n_dark : {1, 3, 12}) {
    Odometry odometry(FeatureWorld::Camera(), VoOptions());
    for (int i = 0; i < 5; ++i) odometry.Track(i * kFrame_ns, world.Observe(at(i), 0.3, i));
    for (int i = 5; i < 5 + n_dark; ++i) odometry.Track(i * kFrame_ns, {});
    const int back = 5 + n_dark;
    ASSERT_EQ(odometry.Track(back * kFrame_ns, world.Observe(at(back), 0.3, back)).state, TrackingState::kRecovered);
    const OdometryResult dark = odometry.Track((back + 1) * kFrame_ns, {});
    if (n_dark < 5) {
      EXPECT_NEAR(dark.T_prev_c.translation().z(), 0.08, 0.01) << n_dark << " dark frames";
      EXPECT_LT(std::sqrt(dark.motion_covariance(2, 2)), 0.2);
    } else {
      EXPECT_GT(std::sqrt(dark.motion_covariance(2, 2)), 0.2) << "how fast it is is not known any more";
    }
  }
}

// Normalised squared error of the motion between keyframes: 6 where the covariance is right.
TEST(OdometryCovariance, EdgesBetweenKeyframesAreConsistent) {
  double sum = 0.0;
  int n = 0;
  VoOptions options;
  options.landmarks.line_model_sigma_px = 0.0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const FeatureWorld world({300, 60}, 7 * seed);
    Odometry odometry(FeatureWorld::Camera(), options);
    SE3 T_w_kf = PathAt(0);
    for (int i = 0; i < 100; ++i) {
      const auto result = odometry.Track(i * kFrame_ns, world.Observe(PathAt(i), 0.3, i + 1000 * seed));
      if (i == 0 || !result.keyframe) continue;
      const Vector6d error = ((T_w_kf.Inverse() * PathAt(i)).Inverse() * result.keyframe->T_prevkf_kf).Log();
      sum += error.dot(result.keyframe->covariance.ldlt().solve(error));
      ++n;
      T_w_kf = PathAt(i);
    }
  }
  ASSERT_GT(n, 10);
  RecordProperty("nees", std::to_string(sum / n));
  EXPECT_GT(sum / n, 3.0);
  EXPECT_LT(sum / n, 9.0);
}

// At 200 Hz two of ten frames are dropped, and few features are left: weak, but the pose is known.
TEST(OdometryGaps, DroppedFramesWithFewFeatures) {
  const FeatureWorld world({300, 0}, 9);
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 300; ++i) {
    if (i % 10 == 3 || i % 10 == 4) continue;
    const SE3 T_w_c = PathAt(0.1 * i);
    StereoFeatures seen = world.Observe(T_w_c, 0.3, i);
    if (i > 100 && seen.points.size() > 20) seen.points.resize(20);
    const OdometryResult result = odometry.Track(i * kFrame_ns / 10, seen);
    ASSERT_NE(result.state, TrackingState::kLost) << "frame " << i;
    const SE3 error = (PathAt(0).Inverse() * T_w_c).Inverse() * result.T_odom_c;
    ASSERT_LT(error.translation().norm(), 0.05) << "frame " << i;
  }
}

// Segments get no information along their direction without a measurement: 50 s of a static camera in front of upright
// bars.
TEST(OdometryGaps, LinesSeenForLongKeepTheirEndpoints) {
  std::vector<FeatureWorld::Line> bars;
  for (int i = 0; i < 9; ++i) {
    const Eigen::Vector3d foot(0.4 * i - 1.6, 0.8, 3.5 + 0.2 * (i % 3));
    bars.push_back({{foot, foot + Eigen::Vector3d(0.1 * (i % 4), -1.5, 0.1 * (i % 5))}, {}});
  }
  const FeatureWorld world({}, bars, 10.0);
  const auto n_bars = static_cast<int>(bars.size());
  LocalLandmarks landmarks(FeatureWorld::Camera(), VoOptions());
  TrackedFrame first(world.Observe(SE3(), 0.1, 0));
  landmarks.Create(SE3(), first);
  FrameMatches matches;
  for (int i = 0; i < n_bars; ++i) matches.lines.push_back({i, i});
  for (uint64_t i = 1; i < 1000; ++i) {
    TrackedFrame frame(world.Observe(SE3(), 0.1, i));
    ASSERT_EQ(frame.features.lines.size(), bars.size());
    landmarks.Update(SE3(), matches, frame);
  }
  ASSERT_EQ(landmarks.lines.landmarks().size(), bars.size());
  for (int i = 0; i < n_bars; ++i) {
    const double truth_m = (bars[i].segment_w.q - bars[i].segment_w.p).norm();
    EXPECT_NEAR(Length_m(landmarks.lines.landmarks()[i]), truth_m, 0.05 * truth_m) << i;
  }
}

}  // namespace
}  // namespace plslam::vo
