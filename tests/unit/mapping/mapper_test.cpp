// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <string>

#include <gtest/gtest.h>

#include "core/map/map_follower.h"
#include "mapping_process/mapper.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::Encoded;
using test::FeatureWorld;
using test::MapAll;
using test::MapOne;
using test::Walk;
using test::WalkOptions;

double MeanObservations(const Map& map) {
  const MapTotals totals = map.Totals();
  return static_cast<double>(totals.point_observations + totals.line_observations) /
         static_cast<double>(totals.points + totals.lines);
}

double Median(const std::vector<double>& ascending) { return ascending[ascending.size() / 2]; }

struct WalkSituation {
  std::string name;
  FeatureWorld::Counts counts;
  bool with_ids = true;
};

void PrintTo(const WalkSituation& situation, std::ostream* stream) { *stream << situation.name; }

class MapperWalk : public testing::TestWithParam<WalkSituation> {
 protected:
  MapperWalk() : world_(GetParam().counts, 7) {
    WalkOptions options;
    options.with_ids = GetParam().with_ids;
    walk_ = test::MakeWalk(world_, test::TurningPath(20), options);
  }

  FeatureWorld world_;
  Walk walk_;
};

TEST_P(MapperWalk, PosesAreBetterThanTheChainedOdometry) {
  const Mapper mapper = MapAll(walk_.keyframes);
  ASSERT_EQ(test::WrongWith(mapper.map()), "");
  ASSERT_EQ(test::ExactlyKnown(mapper.map()), 0);
  const double before_m = test::OdometryError_m(walk_);
  const double after_m = test::PositionError_m(mapper.map(), walk_.T_w_c);
  ASSERT_GT(before_m, 0.02);
  EXPECT_LT(after_m, 0.3 * before_m);
  EXPECT_LT(after_m, 0.01);
}

TEST_P(MapperWalk, LandmarksAreNearTheTruth) {
  const Mapper mapper = MapAll(walk_.keyframes);
  // One pair of images determines a point at 5 m to about 0.2 m; the ends of a segment are less certain than its
  // middle.
  const auto check = [](const std::vector<double>& errors_m, int in_world, double median_m, double most_m) {
    if (in_world == 0) {
      EXPECT_TRUE(errors_m.empty());
      return;
    }
    ASSERT_GT(errors_m.size(), static_cast<size_t>(in_world) / 2);
    EXPECT_LT(Median(errors_m), median_m) << "of " << errors_m.size() << ", largest " << errors_m.back();
    EXPECT_LT(errors_m[errors_m.size() * 9 / 10], most_m);
  };
  check(test::PointErrors_m(mapper.map(), world_), GetParam().counts.points, 0.05, 0.2);
  check(test::LineErrors_m(mapper.map(), world_), GetParam().counts.lines, 0.1, 0.5);
}

TEST_P(MapperWalk, ObservationsGrowAndEverythingIsConnected) {
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  for (const Keyframe& keyframe : walk_.keyframes) {
    ASSERT_TRUE(MapOne(keyframe, mapper));
    const KeyframeId id = mapper.map().keyframes().rbegin()->first;
    if (id == 5) {
      EXPECT_GT(MeanObservations(mapper.map()), 2.0);
    }
    if (id == 0) continue;
    const auto neighbours = mapper.map().Neighbours(id, 1);
    ASSERT_FALSE(neighbours.empty()) << id;
    EXPECT_GE(neighbours.front().shared, 15) << id;
    EXPECT_GE(mapper.map().FindKeyframe(id)->parent_id, 0) << id;
  }
  EXPECT_GT(MeanObservations(mapper.map()), 3.0);
  for (const auto& [id, keyframe] : mapper.map().keyframes()) {
    EXPECT_EQ(keyframe.parent_id < 0, id == 0) << id << " has parent " << keyframe.parent_id;
  }
}

TEST_P(MapperWalk, AdjustmentReducesErrorWithinItsLimits) {
  const WindowOptions window;
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  for (const Keyframe& keyframe : walk_.keyframes) {
    ASSERT_TRUE(MapOne(keyframe, mapper));
    const AdjustmentFigures& figures = mapper.figures();
    EXPECT_LE(figures.rms_after, figures.rms_before + 1e-9) << keyframe.name.number;
    EXPECT_LE(figures.n_keyframes, window.keyframes);
    EXPECT_LE(figures.n_fixed_keyframes, window.fixed_keyframes + 1);
    EXPECT_LE(figures.n_points, window.max_points);
    EXPECT_LE(figures.n_lines, window.max_lines);
    if (keyframe.name.number < 4) continue;
    EXPECT_LT(figures.rms_after, 1.5) << keyframe.name.number;
  }
}

// As in a live stream: keyframes queue during a solve.
TEST_P(MapperWalk, MotionAcrossMissingKeyframesIsLessCertain) {
  constexpr size_t kBefore = 4;
  constexpr size_t kAfter = 7;
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  for (size_t i = 0; i < kBefore; ++i) ASSERT_TRUE(MapOne(walk_.keyframes[i], mapper));
  ASSERT_TRUE(mapper.Insert(walk_.keyframes[kAfter], nullptr));
  const MapKeyframe& newest = mapper.map().keyframes().rbegin()->second;
  const double steps = kAfter - (kBefore - 1);
  EXPECT_TRUE(newest.relative_covariance.isApprox(steps * walk_.keyframes[kAfter].covariance, 1e-9));
}

TEST_P(MapperWalk, SeveralInsertedBeforeOneAdjustment) {
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  std::string reason;
  for (size_t i = 0; i < walk_.keyframes.size(); ++i) {
    ASSERT_TRUE(mapper.Insert(walk_.keyframes[i], &reason)) << reason;
    if (i % 4 != 3) continue;
    mapper.Adjust(nullptr);
    mapper.Cull();
    ASSERT_EQ(test::WrongWith(mapper.map()), "") << i;
  }
  EXPECT_LT(test::PositionError_m(mapper.map(), walk_.T_w_c), 0.3 * test::OdometryError_m(walk_));
}

TEST_P(MapperWalk, AdjustmentThatIsStoppedAtOnceLeavesAMap) {
  const std::atomic<bool> stop{true};
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  std::string reason;
  for (const Keyframe& keyframe : walk_.keyframes) {
    ASSERT_TRUE(mapper.Insert(keyframe, &reason)) << reason;
    mapper.Adjust(&stop);
    mapper.Cull();
    ASSERT_EQ(test::WrongWith(mapper.map()), "") << keyframe.name.number;
    ASSERT_EQ(test::ExactlyKnown(mapper.map()), 0) << keyframe.name.number;
  }
  EXPECT_LT(test::PositionError_m(mapper.map(), walk_.T_w_c), test::OdometryError_m(walk_));
}

TEST_P(MapperWalk, EqualInputGivesEqualBytes) {
  Mapper a(FeatureWorld::Camera(), MappingOptions());
  Mapper b(FeatureWorld::Camera(), MappingOptions());
  for (const Keyframe& keyframe : walk_.keyframes) {
    ASSERT_TRUE(MapOne(keyframe, a));
    ASSERT_TRUE(MapOne(keyframe, b));
    ASSERT_EQ(Encoded(a.TakeUpdate()), Encoded(b.TakeUpdate())) << "keyframe " << keyframe.name.number;
  }
}

TEST_P(MapperWalk, AReplicaFedWithAllUpdatesIsTheWholeMap) {
  Mapper mapper(FeatureWorld::Camera(), MappingOptions());
  MapFollower replica;
  for (const Keyframe& keyframe : walk_.keyframes) {
    ASSERT_TRUE(MapOne(keyframe, mapper));
    ASSERT_EQ(replica.Apply(mapper.TakeUpdate()), MapStep::kNext);
    ASSERT_EQ(replica.version()->number, mapper.version());
    ASSERT_EQ(Encoded(replica.map()), Encoded(mapper.map())) << "keyframe " << keyframe.name.number;
  }
  MapFollower late;
  ASSERT_EQ(late.Apply(mapper.Whole()), MapStep::kNext);
  EXPECT_EQ(Encoded(late.map()), Encoded(replica.map()));
  EXPECT_EQ(mapper.Whole().newest.number, 19);
}

std::string NameOfWalk(const testing::TestParamInfo<WalkSituation>& situation) { return situation.param.name; }

INSTANTIATE_TEST_SUITE_P(Kinds, MapperWalk,
                         testing::Values(WalkSituation{"Points", {200, 0}}, WalkSituation{"Lines", {0, 100}},
                                         WalkSituation{"Both", {150, 50}},
                                         WalkSituation{"PointsWithoutIds", {200, 0}, false},
                                         WalkSituation{"LinesWithoutIds", {0, 100}, false},
                                         WalkSituation{"BothWithoutIds", {150, 50}, false}),
                         NameOfWalk);

}  // namespace

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
      ASSERT_EQ(test::WrongWith(mapper_.map()), "") << keyframe.name.session << ", keyframe " << keyframe.name.number;
      ASSERT_NO_THROW(test::Encoded(mapper_.TakeUpdate()));
      ASSERT_EQ(test::ExactlyKnown(mapper_.map()), 0)
          << keyframe.name.session << ", keyframe " << keyframe.name.number;
    }
  }
  double Error_m(KeyframeId keyframe_id, const SE3& truth) const {
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

TEST_F(Sessions, NewSessionAtTheNewestKeyframesIsJoined) {
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
    const bool of_first = point.observations.front().keyframe_id() < 10;
    EXPECT_EQ(point.observations.back().keyframe_id() < 10, of_first) << "point " << id;
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

TEST_F(Sessions, LocalisedSessionIsPlacedByItsLandmarks) {
  ASSERT_NO_FATAL_FAILURE(Map(first_.keyframes));
  Walk second = Second(world_, end_, T_odom_w_, false);
  Keyframe& keyframe = second.keyframes.front();
  std::map<Descriptor, LandmarkId> by_descriptor;
  for (const auto& [id, point] : mapper_.map().points()) by_descriptor[point.descriptor] = id;
  for (const StereoPoint& point : keyframe.features.points) {
    const auto known = by_descriptor.find(point.left.descriptor);
    keyframe.point_map_ids.push_back(known == by_descriptor.end() ? -1 : known->second);
  }
  ASSERT_NO_FATAL_FAILURE(Map({keyframe}));
  EXPECT_LT(Error_m(mapper_.map().keyframes().rbegin()->first, end_.front()), 0.03);
}

// Robots without common landmarks map as if each were alone.
TEST_F(Sessions, RobotsInDifferentPlacesDoNotInteract) {
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
  const auto is_of_first = [this](KeyframeId id) { return mapper_.map().FindKeyframe(id)->name.session == 100; };
  size_t points = 0;
  for (const auto& [id, point] : mapper_.map().points())
    points += is_of_first(point.observations.front().keyframe_id());
  EXPECT_EQ(points, alone.map().points().size());
  size_t keyframes = 0;
  for (const auto& [id, keyframe] : mapper_.map().keyframes()) {
    if (!is_of_first(id)) continue;
    ++keyframes;
    const auto number = static_cast<size_t>(keyframe.name.number);
    EXPECT_LT(Error_m(id, path[number]), 0.02) << number;
  }
  EXPECT_EQ(keyframes, alone.map().keyframes().size());
}

// Two robots at one place take turns.
TEST_F(Sessions, TwoSessionsAlternate) {
  const Walk second = Second(world_, begin_, T_odom_w_, true);
  for (size_t i = 0; i < begin_.size(); ++i) {
    ASSERT_NO_FATAL_FAILURE(Map({first_.keyframes[i]}));
    ASSERT_NO_FATAL_FAILURE(Map({second.keyframes[i]}));
  }
  for (const auto& [id, keyframe] : mapper_.map().keyframes()) {
    EXPECT_LT(Error_m(id, begin_[static_cast<size_t>(keyframe.name.number)]), 0.03) << "keyframe " << id;
    if (keyframe.previous_id < 0) continue;
    EXPECT_EQ(mapper_.map().FindKeyframe(keyframe.previous_id)->name.session, keyframe.name.session)
        << "keyframe " << id;
  }
}

}  // namespace
}  // namespace plslam::mapping
