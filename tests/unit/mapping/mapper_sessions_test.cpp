// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <gtest/gtest.h>

#include "mapping_process/mapper.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::FeatureWorld;
using test::Walk;
using test::WalkOptions;

/// A session of ten keyframes, and another that starts while its map exists.
class Sessions : public testing::Test {
 protected:
  /// `T_odom_w` is the other frame of the second session's odometry.
  Walk Second(const FeatureWorld& world, const std::vector<SE3>& path, const SE3& T_odom_w, bool with_ids) const {
    WalkOptions options;
    options.session = 8;
    options.seed = 2;
    options.with_ids = with_ids;
    Walk walk = test::MakeWalk(world, path, options);
    for (Keyframe& keyframe : walk.keyframes) keyframe.T_odom_kf = T_odom_w * keyframe.T_odom_kf;
    return walk;
  }
  void Map(const std::vector<Keyframe>& keyframes) {
    for (const Keyframe& keyframe : keyframes) {
      std::string reason;
      ASSERT_TRUE(test::MapOne(keyframe, mapper_, &reason)) << reason;
      ASSERT_EQ(test::WrongWith(mapper_.map()), "") << keyframe.session << ", keyframe " << keyframe.keyframe_id;
      ASSERT_NO_THROW(test::Encoded(mapper_.TakeUpdate()));
      ASSERT_EQ(test::ExactlyKnown(mapper_.map()), 0) << keyframe.session << ", keyframe " << keyframe.keyframe_id;
    }
  }
  double Error_m(int64_t keyframe_id, const SE3& truth) const {
    return (mapper_.map().FindKeyframe(keyframe_id)->T_w_kf.translation() - truth.translation()).norm();
  }

  FeatureWorld world_{{120, 40}, 7};
  std::vector<SE3> path_ = test::TurningPath(20);
  std::vector<SE3> begin_{path_.begin(), path_.begin() + 10};
  std::vector<SE3> end_{path_.begin() + 9, path_.end()};
  SE3 T_odom_w_{ExpSO3(Eigen::Vector3d(0.3, 1.0, -0.2)), Eigen::Vector3d(5.0, -3.0, 11.0)};
  Walk first_ = test::MakeWalk(world_, begin_, {});
  Mapper mapper_{FeatureWorld::Camera(), MappingOptions()};
};

TEST_F(Sessions, NewSessionThatSeesTheNewestPlacesIsJoinedToTheMap) {
  ASSERT_NO_FATAL_FAILURE(Map(first_.keyframes));
  const Walk second = Second(world_, end_, T_odom_w_, false);
  ASSERT_NO_FATAL_FAILURE(Map({second.keyframes.front()}));
  const MapKeyframe joined = mapper_.map().keyframes().rbegin()->second;
  EXPECT_EQ(joined.previous_id, -1);
  EXPECT_GE(joined.parent_id, 0);
  EXPECT_LT(Error_m(joined.id, end_.front()), 0.03);
  ASSERT_NO_FATAL_FAILURE(Map({second.keyframes.begin() + 1, second.keyframes.end()}));
  EXPECT_LT(Error_m(mapper_.map().keyframes().rbegin()->first, end_.back()), 0.03);
}

// The tracker's ids of another session are other landmarks, though the numbers are the same.
TEST_F(Sessions, IdsOfTheTrackerMeanNothingInAnotherSession) {
  ASSERT_NO_FATAL_FAILURE(Map(first_.keyframes));
  const FeatureWorld elsewhere({120, 40}, 99);
  const Walk second = Second(elsewhere, end_, T_odom_w_, true);
  ASSERT_NO_FATAL_FAILURE(Map(second.keyframes));
  for (const auto& [id, point] : mapper_.map().points()) {
    const bool of_first = point.observations.front().keyframe_id < 10;
    EXPECT_EQ(point.observations.back().keyframe_id < 10, of_first) << "point " << id;
  }
}

TEST_F(Sessions, NewSessionElsewhereBeginsWithoutConnection) {
  ASSERT_NO_FATAL_FAILURE(Map(first_.keyframes));
  const MapKeyframe newest = mapper_.map().keyframes().rbegin()->second;
  const FeatureWorld elsewhere({120, 40}, 99);
  const Walk second = Second(elsewhere, end_, T_odom_w_, false);
  ASSERT_NO_FATAL_FAILURE(Map({second.keyframes.front()}));
  const MapKeyframe begun = mapper_.map().keyframes().rbegin()->second;
  EXPECT_EQ(begun.previous_id, -1);
  EXPECT_TRUE(mapper_.map().Neighbours(begun.id, 1).empty());
  EXPECT_LT((newest.T_w_kf.Inverse() * begun.T_w_kf).Log().norm(), 1e-9);
  EXPECT_GE(begun.covariance.diagonal().minCoeff(), 1.0);
  ASSERT_NO_FATAL_FAILURE(Map({second.keyframes.begin() + 1, second.keyframes.end()}));
  // Within itself it is mapped as well as any.
  const SE3 T_first_last = begun.T_w_kf.Inverse() * mapper_.map().keyframes().rbegin()->second.T_w_kf;
  const SE3 truth = end_.front().Inverse() * end_.back();
  EXPECT_LT((T_first_last.translation() - truth.translation()).norm(), 0.02);
}

TEST_F(Sessions, NewSessionThatWasLocalisedByTheTrackerIsPlacedByItsLandmarks) {
  ASSERT_NO_FATAL_FAILURE(Map(first_.keyframes));
  Walk second = Second(world_, end_, T_odom_w_, false);
  Keyframe& keyframe = second.keyframes.front();
  std::map<Descriptor, int64_t> by_descriptor;
  for (const auto& [id, point] : mapper_.map().points()) by_descriptor[point.descriptor] = id;
  for (const StereoPoint& point : keyframe.features.points) {
    const auto known = by_descriptor.find(point.left.descriptor);
    keyframe.point_map_ids.push_back(known == by_descriptor.end() ? -1 : known->second);
  }
  ASSERT_NO_FATAL_FAILURE(Map({keyframe}));
  EXPECT_LT(Error_m(mapper_.map().keyframes().rbegin()->first, end_.front()), 0.03);
}

// Robots that have nothing in common map as if each were alone.
TEST_F(Sessions, RobotsInDifferentPlacesLeaveEachOthersLandmarksAlone) {
  const std::vector<SE3> path = test::CorridorPath(20, 0.25);
  std::vector<Walk> walks;
  for (int robot = 0; robot < 4; ++robot) {
    WalkOptions options;
    options.session = 100 + robot;
    options.seed = static_cast<uint64_t>(1 + robot);
    walks.push_back(test::MakeWalk(test::MakeCorridor(20.0, 20.0, 5.0, 10 + robot), path, options));
  }
  const Mapper alone = test::MapAll(walks.front().keyframes);
  for (size_t i = 0; i < path.size(); ++i) {
    for (const Walk& walk : walks) ASSERT_NO_FATAL_FAILURE(Map({walk.keyframes[i]}));
  }
  const auto is_of_first = [this](int64_t id) { return mapper_.map().FindKeyframe(id)->session == 100; };
  size_t points = 0;
  for (const auto& [id, point] : mapper_.map().points())
    points += is_of_first(point.observations.front().keyframe_id);
  EXPECT_EQ(points, alone.map().points().size());
  size_t keyframes = 0;
  for (const auto& [id, keyframe] : mapper_.map().keyframes()) {
    if (!is_of_first(id)) continue;
    ++keyframes;
    const auto number = static_cast<size_t>(keyframe.session_keyframe_id);
    EXPECT_LT(Error_m(id, path[number]), 0.02) << number;
  }
  EXPECT_EQ(keyframes, alone.map().keyframes().size());
}

// Two robots in one place take turns.
TEST_F(Sessions, TwoSessionsAlternate) {
  const Walk second = Second(world_, begin_, T_odom_w_, true);
  for (size_t i = 0; i < begin_.size(); ++i) {
    ASSERT_NO_FATAL_FAILURE(Map({first_.keyframes[i]}));
    ASSERT_NO_FATAL_FAILURE(Map({second.keyframes[i]}));
  }
  for (const auto& [id, keyframe] : mapper_.map().keyframes()) {
    EXPECT_LT(Error_m(id, begin_[static_cast<size_t>(keyframe.session_keyframe_id)]), 0.03) << "keyframe " << id;
    if (keyframe.previous_id < 0) continue;
    EXPECT_EQ(mapper_.map().FindKeyframe(keyframe.previous_id)->session, keyframe.session) << "keyframe " << id;
  }
}

}  // namespace
}  // namespace plslam::mapping
