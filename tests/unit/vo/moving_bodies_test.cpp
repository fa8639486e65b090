// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/bodies/moving_bodies.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/feature_world.h"
#include "tests/unit/vo/feature_path.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

using test::FeatureWorld;
using test::kFrame_ns;
using test::PathAt;

constexpr double kNoise_px = 0.3;

/// Returns a box full of points, 1.6 x 1.2 x 0.5 m around `middle`.
FeatureWorld Box(int points, uint64_t seed, const Eigen::Vector3d& middle = Eigen::Vector3d::Zero()) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  std::vector<FeatureWorld::Point> all;
  for (int i = 0; i < points; ++i) {
    const double z = 0.5 * unit(generator);
    const double y = 1.2 * unit(generator);
    const Eigen::Vector3d p(1.6 * unit(generator), y, z);
    all.push_back({middle + p, {generator(), generator(), generator(), generator()}});
  }
  return {std::move(all), {}, 100.0};
}

/// Points and lines of the world, and a box in front of them whose features are last.
struct Scene {
  FeatureWorld world{{250, 40}, 3};
  FeatureWorld box = Box(150, 4);

  /// `T_w_b`: pose of the box; null: it is not there.
  StereoFeatures See(const SE3& T_w_c, const SE3* T_w_b, int frame) {
    const auto seed = static_cast<uint64_t>(frame);
    StereoFeatures features = world.Observe(T_w_c, kNoise_px, seed);
    n_world_points = features.points.size();
    if (T_w_b == nullptr) return features;
    const StereoFeatures on_box = box.Observe(T_w_b->Inverse() * T_w_c, kNoise_px, seed + 1000);
    features.points.insert(features.points.end(), on_box.points.begin(), on_box.points.end());
    return features;
  }

  size_t n_world_points = 0;
};

struct Shares {
  double of_box = 0.0;    ///< share of the box's features that are named its
  double of_world = 0.0;  ///< share of the world's that are
};

Shares NamedOnBody(const OdometryResult& result, size_t n_world_points) {
  const auto on_body = [](const FeatureTrack& track) { return !track.IsOfWorld(); };
  const auto middle = result.point_tracks.begin() + static_cast<std::ptrdiff_t>(n_world_points);
  const auto share = [&](auto begin, auto end) {
    return begin == end ? 0.0
                        : static_cast<double>(std::count_if(begin, end, on_body)) / static_cast<double>(end - begin);
  };
  return {share(middle, result.point_tracks.end()), share(result.point_tracks.begin(), middle)};
}

double PositionError(const OdometryResult& result, int frame) {
  return (result.T_odom_c.translation() - (PathAt(0).Inverse() * PathAt(frame)).translation()).norm();
}

/// 3 m ahead of where the camera starts, `metres` to the right.
SE3 AheadBy(double metres) { return PathAt(0) * SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(metres, 0.1, 3.0)); }

TEST(MovingBodies, NothingMovesInAStaticWorld) {
  Scene scene;
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 40; ++i) {
    const SE3 T_w_b = AheadBy(0.0);
    const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(PathAt(i), &T_w_b, i));
    ASSERT_EQ(result.state, TrackingState::kTracking);
    ASSERT_EQ(result.n_moving, 0) << "frame " << i;
    ASSERT_EQ(result.n_bodies, 0) << "frame " << i;
  }
}

TEST(MovingBodies, BodyEnteringTheViewIsSeparated) {
  Scene scene;
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 50; ++i) {
    const SE3 T_w_b = AheadBy(-3.0 + 0.1 * i);  // 2 m/s
    const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(PathAt(i), &T_w_b, i));
    EXPECT_EQ(result.state, TrackingState::kTracking) << "frame " << i;
    EXPECT_LT(PositionError(result, i), 0.02) << "frame " << i;
    if (i < 25 || i > 35) continue;
    const Shares named = NamedOnBody(result, scene.n_world_points);
    EXPECT_GT(named.of_box, 0.9) << "frame " << i;
    EXPECT_LT(named.of_world, 0.15) << "frame " << i;
    EXPECT_EQ(result.n_bodies, 1);
    EXPECT_GT(result.n_moving, 100);
  }
}

TEST(MovingBodies, TheirPathIsEstimated) {
  Scene scene;
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  std::optional<SE3> T_body_b;
  int seen = 0;
  for (int i = 0; i < 45; ++i) {
    const SE3 T_w_b = AheadBy(-3.0 + 0.1 * i);
    const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(PathAt(i), &T_w_b, i));
    if (result.bodies.empty()) continue;
    ASSERT_EQ(result.bodies.size(), 1U);
    const BodyPose& body = result.bodies.front();
    EXPECT_EQ(body.id, 0);
    EXPECT_GT(body.n_features, 50);
    const SE3 T_w_body = PathAt(i) * body.T_c_body;
    if (!T_body_b) T_body_b = T_w_body.Inverse() * T_w_b;
    EXPECT_LT(((T_w_body * *T_body_b).translation() - T_w_b.translation()).norm(), 0.03) << "frame " << i;
    EXPECT_LT(T_body_b->translation().norm(), 0.8) << "it is in the box";
    ++seen;
  }
  EXPECT_GT(seen, 25);
}

// While the world is invisible, the box is not mistaken for it, nor afterwards.
TEST(MovingBodies, AreTrackedWhileTheCameraIsLost) {
  Scene scene;
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 45; ++i) {
    const SE3 T_w_b = AheadBy(-2.6 + 0.1 * i);
    StereoFeatures features = scene.See(PathAt(i), &T_w_b, i);
    const bool hidden = i >= 25 && i < 30;
    if (hidden) {
      features.points.erase(features.points.begin(),
                            features.points.begin() + static_cast<std::ptrdiff_t>(scene.n_world_points));
      features.lines.clear();
      scene.n_world_points = 0;
    }
    const OdometryResult result = odometry.Track(i * kFrame_ns, std::move(features));
    if (hidden) {
      EXPECT_EQ(result.state, TrackingState::kLost) << "frame " << i;
    } else {
      EXPECT_NE(result.state, TrackingState::kLost) << "frame " << i;
      EXPECT_LT(PositionError(result, i), 0.02) << "frame " << i;
    }
    if (i < 20 || i > 38) continue;
    EXPECT_GT(NamedOnBody(result, scene.n_world_points).of_box, 0.8) << "frame " << i;
    ASSERT_EQ(result.bodies.size(), 1U) << "frame " << i;
    EXPECT_EQ(result.bodies.front().id, 0);
  }
}

// Two boxes of equal size from the first frame on, one of which is static: they cannot be distinguished.
TEST(MovingBodies, AmbiguousWorldMakesAllFramesWeak) {
  Scene scene{Box(200, 7, AheadBy(-1.0).translation()), Box(200, 4)};
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 8; ++i) {
    const SE3 T_w_b = AheadBy(0.6 + 0.2 * i);
    const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(PathAt(i), &T_w_b, i));
    if (i == 0) continue;
    EXPECT_EQ(result.state, TrackingState::kWeak) << "frame " << i;
    const SE3 T_odom_c = PathAt(0).Inverse() * PathAt(i);
    const Vector6d error = (result.T_odom_c.Inverse() * T_odom_c).Log();
    EXPECT_LT(error.dot(result.covariance.ldlt().solve(error)), 25.0) << "frame " << i;
  }
}

// No draw of the points ends in a motion that is neither the world's nor the box's.
TEST(MovingBodies, FirstPairIsNoMixture) {
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Scene scene{Box(200, 100 + seed, AheadBy(-1.0).translation()), Box(200, 200 + seed)};
    Odometry odometry(FeatureWorld::Camera(), VoOptions());
    for (int i = 0; i < 2; ++i) {
      const SE3 T_w_b = AheadBy(0.6 + 0.2 * i);
      const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(PathAt(i), &T_w_b, i));
      if (i == 0) continue;
      const SE3 T_odom_c = PathAt(0).Inverse() * PathAt(i);
      const SE3 T_odom_c_of_box = PathAt(0).Inverse() * AheadBy(0.6) * AheadBy(0.8).Inverse() * PathAt(i);
      const double off_world = (result.T_odom_c.Inverse() * T_odom_c).Log().norm();
      const double off_box = (result.T_odom_c.Inverse() * T_odom_c_of_box).Log().norm();
      EXPECT_LT(std::min(off_world, off_box), 0.03) << "seed " << seed;
      const Vector6d error = (result.T_odom_c.Inverse() * T_odom_c).Log();
      EXPECT_LT(error.dot(result.covariance.ldlt().solve(error)), 25.0) << "seed " << seed;
    }
  }
}

/// An inertial sensor at the camera's place with biases that are not known, sampled at 200 Hz from the path.
struct PathSensor {
  MountedImu mounted{SE3(), {SE3(), {1.7e-4, 1.9e-5, 2e-3, 1e-3}, 0.0, 200.0}};

  /// Sets the samples up to a frame.
  static void Expect(int frame, Odometry& odometry) {
    constexpr double kStep = 0.1;  // frames
    constexpr double kStep_s = 1e-9 * kFrame_ns * kStep;
    std::vector<ImuSample> samples;
    for (double f = frame - 1.5; f < frame + 0.5; f += kStep) {
      const SE3 before = PathAt(f - kStep), now = PathAt(f), after = PathAt(f + kStep);
      const Eigen::Vector3d acceleration =
          (after.translation() - 2.0 * now.translation() + before.translation()) / (kStep_s * kStep_s);
      const Eigen::Vector3d turn = (before.Inverse() * after).Log().tail<3>();
      samples.push_back({std::llround(f * static_cast<double>(kFrame_ns)),
                         turn / (2.0 * kStep_s) + Eigen::Vector3d(0.01, -0.02, 0.01),
                         now.rotation().conjugate() * (acceleration - Eigen::Vector3d(0.0, 9.81, 0.0)) +
                             Eigen::Vector3d(0.05, 0.05, -0.05)});
    }
    odometry.ExpectImu(samples, (frame - 1) * kFrame_ns, frame * kFrame_ns);
  }
};

// The box drives through a bend at 34 degrees/s.
TEST(MovingBodies, SensorFindsTheWorldInTheFirstPair) {
  const auto box = [](int i) {
    return AheadBy(0.6 + 0.2 * i) * SE3(ExpSO3(Eigen::Vector3d(0.0, 0.03 * i, 0.0)), Eigen::Vector3d::Zero());
  };
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Scene scene{Box(200, 100 + seed, AheadBy(-1.0).translation()), Box(200, 200 + seed)};
    Odometry odometry(FeatureWorld::Camera(), VoOptions(), {}, PathSensor().mounted);
    for (int i = 0; i < 2; ++i) {
      const SE3 T_w_b = box(i);
      if (i > 0) PathSensor::Expect(i, odometry);
      const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(PathAt(i), &T_w_b, i));
      if (i == 0) continue;
      EXPECT_LT(PositionError(result, i), 0.03) << "seed " << seed;
      EXPECT_EQ(result.state, TrackingState::kTracking) << "seed " << seed;
    }
  }
}

// The box drives straight on at first, so that it may be the world, and then brakes.
TEST(MovingBodies, SensorReplacesAWrongWorld) {
  int n_wrong = 0, n_right = 0;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    Scene scene{Box(80, 100 + seed, AheadBy(-1.0).translation()), Box(300, 200 + seed)};
    Odometry odometry(FeatureWorld::Camera(), VoOptions(), {}, PathSensor().mounted);
    OdometryResult result;
    for (int i = 0; i < 25; ++i) {
      const double braking_s = 0.05 * std::max(0, i - 5);
      const SE3 T_w_b = AheadBy(0.2 + 0.1 * i - braking_s * braking_s);
      if (i > 0) PathSensor::Expect(i, odometry);
      result = odometry.Track(i * kFrame_ns, scene.See(PathAt(i), &T_w_b, i));
      if (i == 5 && PositionError(result, i) > 0.05) ++n_wrong;
    }
    EXPECT_EQ(result.state, TrackingState::kTracking) << "seed " << seed;
    EXPECT_LT(PositionError(result, 24), 0.3) << "seed " << seed;
    n_right += PositionError(result, 24) < 0.02 ? 1 : 0;
  }
  EXPECT_GE(n_right, 9) << "one is lost in the first pair";
  EXPECT_GT(n_wrong, 1) << "otherwise nothing is replaced";
}

// One of the two leaves: the other one is a world again, whichever was taken for it.
TEST(MovingBodies, AmbiguousWorldIsNotKeptAsABody) {
  for (const bool box_stays : {false, true}) {
    Scene scene{Box(200, 7, AheadBy(-1.0).translation()), Box(200, 4)};
    Odometry odometry(FeatureWorld::Camera(), VoOptions());
    OdometryResult result;
    for (int i = 0; i < 12; ++i) {
      const SE3 T_w_b = AheadBy(0.6 + 0.2 * std::min(i, 7));
      StereoFeatures features = scene.See(PathAt(i), &T_w_b, i);
      const auto middle = features.points.begin() + static_cast<std::ptrdiff_t>(scene.n_world_points);
      if (i >= 8 && box_stays) features.points.erase(features.points.begin(), middle);
      if (i >= 8 && !box_stays) features.points.erase(middle, features.points.end());
      result = odometry.Track(i * kFrame_ns, std::move(features));
    }
    EXPECT_NE(result.state, TrackingState::kLost) << box_stays;
  }
}

// A rear and a front with a gap in between, too far apart to be detected as one.
TEST(MovingBodies, PartsThatMoveAlikeAreOneBody) {
  Scene scene;
  const FeatureWorld front = Box(150, 5, {2.2, 0.0, 1.0});
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  for (int i = 0; i < 60; ++i) {
    const SE3 T_w_b = AheadBy(-4.5 + 0.1 * i);
    StereoFeatures features = scene.See(PathAt(i), &T_w_b, i);
    const StereoFeatures more =
        front.Observe(T_w_b.Inverse() * PathAt(i), kNoise_px, 2000 + static_cast<uint64_t>(i));
    features.points.insert(features.points.end(), more.points.begin(), more.points.end());
    const OdometryResult result = odometry.Track(i * kFrame_ns, std::move(features));
    EXPECT_LE(result.n_bodies, 1) << "frame " << i;
    EXPECT_LT(PositionError(result, i), 0.02) << "frame " << i;
  }
}

// A box covers nearly all of the view: the rest of the world agrees with the motion so far and is not enough to
// determine it.
TEST(MovingBodies, HiddenWorldMakesTheFrameWeak) {
  Scene scene{{{120, 20}, 3}, Box(200, 4)};
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  int weak = 0;
  for (int i = 0; i < 40; ++i) {
    const SE3 T_w_b = AheadBy(-2.0 + 0.1 * i);
    StereoFeatures features = scene.See(PathAt(i), &T_w_b, i);
    if (i >= 30) {
      // All but 15 points of the world.
      features.points.erase(features.points.begin() + 15,
                            features.points.begin() + static_cast<std::ptrdiff_t>(scene.n_world_points));
      features.lines.clear();
    }
    const OdometryResult result = odometry.Track(i * kFrame_ns, std::move(features));
    EXPECT_NE(result.state, TrackingState::kLost) << "frame " << i;
    EXPECT_LT(PositionError(result, i), 0.05) << "frame " << i;
    if (i >= 31 && result.state == TrackingState::kWeak) ++weak;
  }
  EXPECT_EQ(weak, 9);
}

TEST(MovingBodies, KeyframesWithdrawPointsOnBodies) {
  Scene scene;
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  size_t withdrawn = 0;
  for (int i = 0; i < 60; ++i) {
    // It is static in the first keyframe, and moves after ten frames.
    const SE3 T_w_b = AheadBy(0.1 * std::max(0, i - 10));
    const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(PathAt(i), &T_w_b, i));
    if (!result.keyframe) continue;
    for (const FeatureTrack& track : result.keyframe->content.point_tracks) ASSERT_TRUE(track.IsOfWorld());
    withdrawn += result.keyframe->withdrawn_points.size();
  }
  EXPECT_GT(withdrawn, 80U);
}

TEST(MovingBodies, MoreFeaturesDoNotMakeItTheWorld) {
  // From the first frame on a box that moves with the camera has most of the features, in a small part of the image.
  Scene scene{{{90, 15}, 3}, Box(400, 4)};
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  const SE3 T_c_b(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.0, 0.0, 2.5));
  const auto path = [](int frame) {
    return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.06 * frame, 0.0, 0.01 * frame));
  };
  for (int i = 0; i < 30; ++i) {
    const SE3 T_w_b = path(i) * T_c_b;
    const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(path(i), &T_w_b, i));
    // In the second frame only geometry identifies the world.
    if (i > 0) {
      EXPECT_EQ(result.state, i >= 1 && i <= 5 ? TrackingState::kWeak : TrackingState::kTracking) << "frame " << i;
    }
    EXPECT_LT((result.T_odom_c.translation() - path(i).translation()).norm(), 0.02) << "frame " << i;
  }
}

TEST(MovingBodies, StandingBodyBecomesTheWorldAgain) {
  Scene scene;
  Odometry odometry(FeatureWorld::Camera(), VoOptions());
  const auto path = [](int frame) {
    return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.03 * frame, 0.0, 0.0));
  };
  int moving_at_20 = 0;
  int moving_at_end = 0;
  for (int i = 0; i < 60; ++i) {
    const SE3 T_w_b = AheadBy(-2.0 + 0.1 * std::min(i, 25));
    const OdometryResult result = odometry.Track(i * kFrame_ns, scene.See(path(i), &T_w_b, i));
    EXPECT_LT((result.T_odom_c.translation() - path(i).translation()).norm(), 0.02) << "frame " << i;
    if (i == 22) moving_at_20 = result.n_moving;
    moving_at_end = result.n_moving;
  }
  EXPECT_GT(moving_at_20, 80);
  EXPECT_EQ(moving_at_end, 0);
}

}  // namespace
}  // namespace plslam::vo
