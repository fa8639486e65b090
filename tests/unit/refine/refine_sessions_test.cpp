// SPDX-License-Identifier: BSD-3-Clause
// Maps of several sessions, connected or not, and what a map does not determine.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/unit/mapping/mapping_world.h"
#include "tools/refine/refine_map.h"

namespace plslam::refine {
namespace {

constexpr SessionId kFirst = 7;
constexpr SessionId kSecond = 8;

/// A session, whose odometry begins at `T_odom_w` times the path.
test::Walk Session(const test::FeatureWorld& world, const std::vector<SE3>& path, SessionId session,
                   const SE3& T_odom_w, double noise_px) {
  test::WalkOptions options;
  options.session = session;
  options.seed = static_cast<uint64_t>(session.value);
  options.noise_px = noise_px;
  test::Walk walk = test::MakeWalk(world, path, options);
  for (Keyframe& keyframe : walk.keyframes) keyframe.T_odom_kf = T_odom_w * keyframe.T_odom_kf;
  return walk;
}

StoredMap MapOf(const std::vector<const test::Walk*>& walks) {
  mapping::Mapper mapper(test::FeatureWorld::Camera(), {});
  for (const test::Walk* walk : walks) {
    for (const Keyframe& keyframe : walk->keyframes) {
      std::string reason;
      EXPECT_TRUE(test::MapOne(keyframe, mapper, &reason)) << reason;
    }
  }
  return mapper.Store();
}

/// Moves all keyframes but those given by the same step.
void Move(StoredMap& stored, const std::vector<KeyframeId>& except) {
  std::map<KeyframeId, SE3> moved;
  for (const auto& [id, keyframe] : stored.map.keyframes()) {
    if (std::ranges::find(except, id) == except.end())
      moved[id] = keyframe.T_w_kf * SE3::Exp(0.002 * Vector6d::Ones());
  }
  for (const auto& [id, T_w_kf] : moved) stored.map.SetPose(id, T_w_kf, Matrix6d::Zero());
}

/// Largest distance of the keyframes of a session from T_w_true times their true poses.
double Error_m(const Map& map, SessionId session, const SE3& T_w_true, const std::vector<SE3>& truth) {
  double worst_m = 0.0;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.name.session != session) continue;
    const SE3 T_w_kf = T_w_true * truth[static_cast<size_t>(keyframe.name.number)];
    worst_m = std::max(worst_m, (keyframe.T_w_kf.translation() - T_w_kf.translation()).norm());
  }
  return worst_m;
}

KeyframeId FirstOf(const Map& map, SessionId session) {
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.name.session == session) return id;
  }
  return -1;
}

const SE3 kElsewhere(ExpSO3(Eigen::Vector3d(0.3, 1.0, -0.2)), Eigen::Vector3d(5.0, -3.0, 11.0));

// Exact features: the truth is the optimum of both sessions, in the frame of the first one.
TEST(RefineSessions, TwoThatMeetAreOneMap) {
  const test::FeatureWorld world({300, 60}, 3);
  const std::vector<SE3> path = test::TurningPath(20);
  const std::vector<SE3> begin(path.begin(), path.begin() + 10);
  const std::vector<SE3> end(path.begin() + 5, path.end());
  const test::Walk first = Session(world, begin, kFirst, SE3(), 0.0);
  const test::Walk second = Session(world, end, kSecond, kElsewhere, 0.0);
  StoredMap stored = MapOf({&first, &second});
  Move(stored, {0});
  ASSERT_GT(Error_m(stored.map, kSecond, SE3(), end), 0.003);
  StereoCamera camera = test::FeatureWorld::Camera();
  const RefineReport report = RefineMap(stored, camera, {});
  EXPECT_EQ(report.parts, 1);
  EXPECT_EQ(stored.sessions.size(), 2U);
  EXPECT_LT(Error_m(stored.map, kFirst, SE3(), begin), 1e-3);
  EXPECT_LT(Error_m(stored.map, kSecond, SE3(), end), 1e-3);
  EXPECT_EQ(test::WrongWith(stored.map), "");
}

// Each part is adjusted in the frame of its own first keyframe.
TEST(RefineSessions, PartsThatNothingConnects) {
  const std::vector<SE3> path = test::TurningPath(12);
  const test::Walk first = Session(test::FeatureWorld({300, 60}, 3), path, kFirst, SE3(), 0.0);
  const test::Walk second = Session(test::FeatureWorld({300, 60}, 4), path, kSecond, kElsewhere, 0.0);
  StoredMap stored = MapOf({&first, &second});
  const KeyframeId first_of_second = FirstOf(stored.map, kSecond);
  ASSERT_GT(first_of_second, 0);
  const SE3 T_w_start = stored.map.FindKeyframe(first_of_second)->T_w_kf;
  Move(stored, {0, first_of_second});
  StereoCamera camera = test::FeatureWorld::Camera();
  const RefineReport report = RefineMap(stored, camera, {});
  EXPECT_EQ(report.parts, 2);
  EXPECT_LT(Error_m(stored.map, kFirst, SE3(), path), 1e-3);
  EXPECT_LT(Error_m(stored.map, kSecond, T_w_start * path[0].Inverse(), path), 1e-3);
  EXPECT_LT((stored.map.FindKeyframe(first_of_second)->T_w_kf.translation() - T_w_start.translation()).norm(), 1e-12);
}

// Without motion the images are the same at whatever time the right one is taken.
TEST(RefineUndetermined, TimeSkewOfAStandingCamera) {
  const test::FeatureWorld world({500, 80}, 1);
  test::WalkOptions options;
  options.motion_sigma_m = options.motion_sigma_rad = 1e-5;
  const test::Walk walk = test::MakeWalk(world, std::vector<SE3>(10), options);
  mapping::MappingOptions mapping;
  mapping.culling.redundant_share = 1.1;  // keeps equal keyframes
  StoredMap stored = test::MapAll(walk.keyframes, mapping).Store();
  ASSERT_EQ(stored.map.keyframes().size(), 10U);
  StereoCamera camera = test::FeatureWorld::Camera();
  RefineOptions refine_options;
  refine_options.camera = CameraChoice::kAll;
  const RefineReport report = RefineMap(stored, camera, refine_options);
  EXPECT_EQ(report.pair.state[reference::kTimeSkew], PairState::kUndetermined)
      << report.pair.value[reference::kTimeSkew] << " sigma " << report.pair.sigma[reference::kTimeSkew];
  EXPECT_EQ(report.pair.value[reference::kTimeSkew], 0.0);
}

TEST(RefineUndetermined, ScaleThatNothingFixes) {
  const test::FeatureWorld world({500, 80}, 1);
  const test::Walk walk = test::MakeWalk(world, test::TurningPath(10), {});
  StoredMap stored = test::MapAll(walk.keyframes).Store();
  std::vector<MapKeyframe> keyframes;
  for (const auto& [id, keyframe] : stored.map.keyframes()) keyframes.push_back(keyframe);
  for (MapKeyframe& keyframe : keyframes) {
    test::ChangeFeatures(stored.features, keyframe.id, [](StereoFeatures& features) {
      for (StereoPoint& point : features.points) point.disparity_px = -1.0;
      for (StereoLine& line : features.lines) line.disparity_p_px = line.disparity_q_px = -1.0;
    });
  }
  StereoCamera camera = test::FeatureWorld::Camera();
  // The motions of the tracker have the scale.
  StoredMap with_motions = stored;
  EXPECT_NO_THROW(RefineMap(with_motions, camera, {}));
  for (MapKeyframe& keyframe : keyframes) {
    keyframe.relative_covariance.setZero();
    stored.map.Put(keyframe);
  }
  const SE3 before = stored.map.keyframes().rbegin()->second.T_w_kf;
  try {
    RefineMap(stored, camera, {});
    FAIL() << "a map without scale was refined";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("fixes the scale"), std::string::npos) << error.what();
  }
  EXPECT_EQ(stored.map.keyframes().rbegin()->second.T_w_kf.translation(), before.translation());
}

}  // namespace
}  // namespace plslam::refine
