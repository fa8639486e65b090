// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_graph.h"
#include "tests/support/dense_algebra.h"
#include "tests/unit/mapping/loop_world.h"

namespace plslam::mapping {
namespace {

using test::FeatureWorld;
using test::Walk;
using test::WalkOptions;

constexpr int kTracking = 1;
constexpr int kRecovered = 4;
constexpr double kRadius_m = 6.0;
constexpr int kRound = 75;

/// Trackers that are relocalised in a ring.
class Relocation : public testing::Test {
 protected:
  /// A session along keyframes `begin` to `end` of the ring. The frame of its odometry is the world's if it is the
  /// first.
  Walk Session(SessionId session, int begin, int end) const {
    WalkOptions options;
    options.session = session;
    options.seed = static_cast<uint64_t>(session.value);
    Walk walk = test::MakeWalk(world_, {path_.begin() + begin, path_.begin() + end}, options);
    // The tracker's numbers are its own.
    for (Keyframe& keyframe : walk.keyframes) {
      for (TrackId& id : keyframe.point_landmark_ids) id.value += 10'000 * session.value;
      for (TrackId& id : keyframe.line_landmark_ids) id.value += 10'000 * session.value;
    }
    return walk;
  }
  void Insert(const Keyframe& keyframe) {
    ASSERT_TRUE(test::MapOne(keyframe, mapper_, &reason_)) << reason_;
    ASSERT_EQ(test::WrongWith(mapper_.map()), "") << keyframe.name.session << ", keyframe " << keyframe.name.number;
  }
  void Insert(const Walk& walk) {
    for (const Keyframe& keyframe : walk.keyframes) ASSERT_NO_FATAL_FAILURE(Insert(keyframe));
  }
  /// Keyframe after `before`, truly at `place` of the ring, that the tracker takes for `T_wrong` from there.
  Keyframe Carried(const Keyframe& before, int place, const SE3& T_wrong) const {
    const StereoFeatures seen = world_.Observe(path_[static_cast<size_t>(place)], 0.4, 99);
    Keyframe keyframe = test::MakeKeyframe(&before, before.T_odom_kf * T_wrong, seen);
    keyframe.state = kRecovered;
    test::GiveMapIds(mapper_.map(), 7, keyframe);
    return keyframe;
  }
  const MapKeyframe& Newest() const { return mapper_.map().keyframes().rbegin()->second; }
  double Error_m(const MapKeyframe& keyframe, int place) const {
    return (keyframe.T_w_kf.translation() - path_[static_cast<size_t>(place)].translation()).norm();
  }
  /// Largest error of a session that began at `begin`.
  double Error_m(SessionId session, int begin) const {
    double most_m = 0.0;
    for (const auto& [id, keyframe] : mapper_.map().keyframes()) {
      if (keyframe.name.session != session) continue;
      most_m = std::max(most_m, Error_m(keyframe, begin + static_cast<int>(keyframe.name.number)));
    }
    return most_m;
  }

  FeatureWorld world_ = test::MakeRing(kRadius_m, 500, 120, 3);
  std::vector<SE3> path_ = test::RingPath(kRadius_m, 0.5, kRound + 20);
  const SE3 T_wrong_{ExpSO3(Eigen::Vector3d(0.2, -1.0, 0.3)), Eigen::Vector3d(2.0, -1.0, 3.0)};
  Mapper mapper_{FeatureWorld::Camera(), MappingOptions()};
  std::string reason_;
};

TEST_F(Relocation, CarriedBackAndFoundAgain) {
  const Walk walk = Session(7, 0, 25);
  ASSERT_NO_FATAL_FAILURE(Insert(walk));
  // The tracker believes in its metre-wrong step to a centimetre.
  const Keyframe found = Carried(walk.keyframes.back(), 6, T_wrong_);
  ASSERT_NO_FATAL_FAILURE(Insert(found));
  EXPECT_LT(Error_m(Newest(), 6), 0.05);
  EXPECT_LT(Newest().parent_id, 15);
  EXPECT_GE(mapper_.map().Neighbours(Newest().id, Map::kCovisible).size(), 3U);
  // The published step is no longer overconfident.
  const Vector6d error =
      (T_wrong_.Inverse() * mapper_.map().FindKeyframe(Newest().previous_id)->T_w_kf.Inverse() * Newest().T_w_kf)
          .Log();
  EXPECT_GT(error.norm(), 1.0);
  EXPECT_LT(test::ChiSquare(error, Newest().relative_covariance), 7.0);
}

// The map's landmarks outweigh the motion in the adjustment, whatever its covariance.
TEST_F(Relocation, WrongMotionDoesNotConstrainTheKeyframe) {
  for (const int state : {kTracking, kRecovered}) {
    Mapper mapper(FeatureWorld::Camera(), MappingOptions());
    std::swap(mapper, mapper_);
    const Walk walk = Session(7, 0, 12);
    ASSERT_NO_FATAL_FAILURE(Insert(walk));
    Keyframe found = Carried(walk.keyframes.back(), 9, T_wrong_);
    found.state = state;
    found.covariance = 1e-8 * Matrix6d::Identity();
    ASSERT_NO_FATAL_FAILURE(Insert(found));
    EXPECT_LT(Error_m(Newest(), 9), 0.05) << state;
    EXPECT_LT(Error_m(*mapper_.map().FindKeyframe(11), 11), 0.05) << state;
    for (int i = 0; i < 3; ++i) mapper_.Adjust(nullptr);
    EXPECT_LT(Error_m(Newest(), 9), 0.05) << state;
    EXPECT_LT(Error_m(*mapper_.map().FindKeyframe(11), 11), 0.05) << state;
  }
}

TEST_F(Relocation, SessionContinuesFromTheRelocatedPose) {
  const Walk walk = Session(7, 0, 25);
  ASSERT_NO_FATAL_FAILURE(Insert(walk));
  Keyframe last = Carried(walk.keyframes.back(), 6, T_wrong_);
  ASSERT_NO_FATAL_FAILURE(Insert(last));
  for (int place = 7; place < 12; ++place) {
    Keyframe next =
        Carried(last, place, path_[static_cast<size_t>(place) - 1].Inverse() * path_[static_cast<size_t>(place)]);
    next.state = kTracking;
    ASSERT_NO_FATAL_FAILURE(Insert(next));
    EXPECT_LT(Error_m(Newest(), place), 0.05);
    last = next;
  }
}

TEST_F(Relocation, FirstKeyframeFarFromTheNewest) {
  ASSERT_NO_FATAL_FAILURE(Insert(Session(7, 0, 40)));
  Walk second = Session(8, 5, 10);
  Keyframe& first = second.keyframes.front();
  first.T_odom_kf = T_wrong_;
  test::GiveMapIds(mapper_.map(), 7, first);
  ASSERT_NO_FATAL_FAILURE(Insert(first));
  EXPECT_EQ(Newest().previous_id, -1);
  EXPECT_GE(Newest().parent_id, 0);
  EXPECT_LT(Error_m(Newest(), 5), 0.05);
  EXPECT_LT(Newest().covariance.diagonal().maxCoeff(), 0.1);
  EXPECT_EQ(MapGraph(mapper_.map()).Component(Newest().id, MapGraph::Edges::kAll).size(),
            mapper_.map().keyframes().size());
}

// A bookcase as another that the newest keyframe sees; all around it is different.
TEST_F(Relocation, RepeatedFurnitureDoesNotJoinASessionToTheMap) {
  world_ = test::MakeRing(kRadius_m, 2000, 300, 3);
  ASSERT_NO_FATAL_FAILURE(Insert(Session(7, 0, 40)));
  const StereoFeatures bookcase = world_.Observe(path_[39], 0.4, 99);
  StereoFeatures seen = test::MakeRing(kRadius_m, 2000, 300, 77).Observe(path_[60], 0.4, 99);
  const double middle_px = FeatureWorld::Camera().left_px + FeatureWorld::Camera().width_px / 2.0;
  for (const StereoPoint& point : bookcase.points) {
    if (point.left.px.x() < middle_px) seen.points.push_back(point);
  }
  for (const StereoLine& line : bookcase.lines) {
    if (line.left.segment.p.x() < middle_px) seen.lines.push_back(line);
  }
  Keyframe first = test::MakeKeyframe(nullptr, T_wrong_, seen);
  first.name.session = 8;
  ASSERT_NO_FATAL_FAILURE(Insert(first));
  EXPECT_LT(Newest().parent_id, 0);
  EXPECT_EQ(MapGraph(mapper_.map()).Component(Newest().id, MapGraph::Edges::kAll).size(), 1U);
}

// For example, the tracker's landmarks are of another map: each feature has a wrong one.
TEST_F(Relocation, WrongAssociationsMoveNothing) {
  const Walk walk = Session(7, 0, 25);
  ASSERT_NO_FATAL_FAILURE(Insert(walk));
  Keyframe next = Carried(walk.keyframes.back(), 25, path_[24].Inverse() * path_[25]);
  next.state = kTracking;
  next.point_landmark_ids = Session(7, 25, 26).keyframes.front().point_landmark_ids;
  std::vector<LandmarkId> ids;
  for (const auto& [id, point] : mapper_.map().points()) ids.push_back(id);
  for (size_t i = 0; i < next.point_map_ids.size(); ++i) next.point_map_ids[i] = ids[(37 * i) % ids.size()];
  next.line_map_ids.clear();
  ASSERT_NO_FATAL_FAILURE(Insert(next));
  EXPECT_LT(Error_m(Newest(), 25), 0.05);
}

// A wrong association with a landmark elsewhere does not affect the landmark's position.
TEST_F(Relocation, FalseLandmarkDoesNotMoveAKeyframe) {
  const Walk walk = Session(7, 0, 12);
  ASSERT_NO_FATAL_FAILURE(Insert(walk));
  const FeatureWorld elsewhere = test::MakeRing(kRadius_m, 500, 120, 99);
  Keyframe next = test::MakeKeyframe(&walk.keyframes.back(), walk.keyframes.back().T_odom_kf * T_wrong_,
                                     elsewhere.Observe(path_[40], 0.4, 99));
  next.state = kRecovered;
  next.point_map_ids.assign(next.features.points.size(), -1);
  // A landmark that the first keyframe observes, and that projects to the feature.
  const SE3 T_kf_w = (Newest().T_w_kf * T_wrong_).Inverse();
  for (const LandmarkId id : mapper_.map().LandmarksOf(0).points) {
    if (id < 0) continue;
    const Eigen::Vector3d p_kf = T_kf_w * mapper_.map().FindPoint(id)->p_w;
    if (p_kf.z() < 1.0) continue;
    const Eigen::Vector3d uvd = FeatureWorld::Camera().ProjectStereo(p_kf);
    next.features.points[0].left.px = uvd.head<2>();
    next.features.points[0].disparity_px = uvd.z();
    next.point_map_ids[0] = id;
    break;
  }
  ASSERT_GE(next.point_map_ids[0], 0);
  ASSERT_NO_FATAL_FAILURE(Insert(next));
  const auto neighbours = mapper_.map().Neighbours(Newest().id, 1);
  ASSERT_FALSE(neighbours.empty()) << "or there is nothing to be seen here";
  ASSERT_NE(neighbours.front().keyframe_id, Newest().previous_id);
  ASSERT_LT(neighbours.front().shared, Map::kParent);
  EXPECT_EQ(Newest().parent_id, Newest().previous_id);
}

class Parts : public Relocation {
 protected:
  size_t SizeOfPart() const { return MapGraph(mapper_.map()).Component(Newest().id, MapGraph::Edges::kAll).size(); }
};

TEST_F(Parts, YoungerTrackerFindsTheOlderPart) {
  ASSERT_NO_FATAL_FAILURE(Insert(Session(7, 0, 15)));
  Walk second = Session(8, 60, 80);
  for (int i = 0; i < 12; ++i) ASSERT_NO_FATAL_FAILURE(Insert(second.keyframes[static_cast<size_t>(i)]));
  ASSERT_LT(SizeOfPart(), mapper_.map().keyframes().size());
  ASSERT_GT(Error_m(8, 60), 1.0);
  for (int i = 12; i < 20; ++i) {
    Keyframe keyframe = second.keyframes[static_cast<size_t>(i)];
    test::GiveMapIds(mapper_.map(), 7, keyframe);
    ASSERT_NO_FATAL_FAILURE(Insert(keyframe));
  }
  EXPECT_EQ(SizeOfPart(), mapper_.map().keyframes().size());
  EXPECT_LT(Error_m(8, 60), 0.15);
  EXPECT_LT(Error_m(7, 0), 0.05);
}

TEST_F(Parts, OlderTrackerFindsTheYoungerPart) {
  const Walk first = Session(7, 60, 85);
  for (int i = 0; i < 8; ++i) ASSERT_NO_FATAL_FAILURE(Insert(first.keyframes[static_cast<size_t>(i)]));
  Walk second = Session(8, 0, 12);
  for (Keyframe& keyframe : second.keyframes) keyframe.T_odom_kf = T_wrong_ * keyframe.T_odom_kf;
  ASSERT_NO_FATAL_FAILURE(Insert(second));
  ASSERT_LT(SizeOfPart(), mapper_.map().keyframes().size());
  ASSERT_GT(Error_m(8, 0), 1.0);
  for (int i = 8; i < 25; ++i) {
    Keyframe keyframe = first.keyframes[static_cast<size_t>(i)];
    test::GiveMapIds(mapper_.map(), 8, keyframe);
    ASSERT_NO_FATAL_FAILURE(Insert(keyframe));
  }
  EXPECT_EQ(SizeOfPart(), mapper_.map().keyframes().size());
  EXPECT_LT(Error_m(8, 0), 0.15);
  EXPECT_LT(Error_m(7, 60), 0.1);
}

// As loop_process does it.
TEST_F(Parts, LoopJoinsTwoParts) {
  ASSERT_NO_FATAL_FAILURE(Insert(Session(7, 0, 15)));
  ASSERT_NO_FATAL_FAILURE(Insert(Session(8, 65, 80)));
  const MapKeyframe newest = Newest();
  ASSERT_LT(SizeOfPart(), mapper_.map().keyframes().size());
  const KeyframeId old_id = mapper_.map().FindKeyframe(4) != nullptr ? 4 : 3;
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.edges.push_back({old_id, newest.id, path_[static_cast<size_t>(old_id.value)].Inverse() * path_[79]});
  closure.edges.front().covariance = 1e-4 * Matrix6d::Identity();
  const SE3 T_w_kf = mapper_.map().FindKeyframe(old_id)->T_w_kf * closure.edges.front().T_old_kf;
  for (const KeyframeId id : MapGraph(mapper_.map()).Component(newest.id, MapGraph::Edges::kAll)) {
    const SE3& T_w_before = mapper_.map().FindKeyframe(id)->T_w_kf;
    closure.poses.push_back({id, T_w_kf * (newest.T_w_kf.Inverse() * T_w_before)});
  }
  const int duplicates = test::Duplicates(mapper_.map());
  ASSERT_GT(duplicates, 20);
  ASSERT_TRUE(mapper_.Correct(closure, &reason_)) << reason_;
  ASSERT_EQ(test::WrongWith(mapper_.map()), "");
  EXPECT_EQ(SizeOfPart(), mapper_.map().keyframes().size());
  EXPECT_LT(Error_m(8, 65), 0.15);
  EXPECT_LT(test::Duplicates(mapper_.map()), duplicates / 3);
  EXPECT_GE(mapper_.map().Shared(old_id, newest.id), Map::kCovisible);
}

}  // namespace
}  // namespace plslam::mapping
