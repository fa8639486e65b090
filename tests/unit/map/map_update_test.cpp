// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map_follower.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/unit/map/random_map.h"

namespace plslam {
namespace {

using Step = MapStep;

template <class Landmark>
void ExpectSameObservations(const IdMap<LandmarkId, Landmark>& a, const IdMap<LandmarkId, Landmark>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (auto x = a.begin(), y = b.begin(); x != a.end(); ++x, ++y) {
    ASSERT_EQ(x->first, y->first);
    ASSERT_EQ(x->second.observations, y->second.observations) << "landmark " << x->first;
    ASSERT_EQ(x->second.descriptor, y->second.descriptor) << "landmark " << x->first;
  }
}

void ExpectSame(const Map& a, const Map& b) {
  ASSERT_EQ(a.Totals(), b.Totals());
  ExpectSameObservations(a.points(), b.points());
  ExpectSameObservations(a.lines(), b.lines());
  for (const auto& [id, keyframe] : a.keyframes()) {
    const MapKeyframe* other = b.FindKeyframe(id);
    ASSERT_NE(other, nullptr) << id;
    ASSERT_EQ(keyframe.T_w_kf.matrix(), other->T_w_kf.matrix());
    ASSERT_EQ(keyframe.covariance, other->covariance) << id;
    ASSERT_EQ(keyframe.parent_id, other->parent_id) << id;
    ASSERT_EQ(a.Children(id), b.Children(id)) << id;
    ASSERT_EQ(a.Neighbours(id, 1), b.Neighbours(id, 1)) << id;
  }
  for (const auto& [id, point] : a.points()) {
    ASSERT_EQ(point.p_w, b.FindPoint(id)->p_w) << id;
    ASSERT_EQ(point.covariance, b.FindPoint(id)->covariance) << id;
  }
  for (const auto& [id, line] : a.lines()) {
    ASSERT_EQ(line.segment_w.q, b.FindLine(id)->segment_w.q) << id;
    ASSERT_EQ(line.covariance_p, b.FindLine(id)->covariance_p) << id;
  }
  for (size_t i = 0; i < a.loops().size(); ++i) {
    ASSERT_EQ(a.loops()[i].old_keyframe_id, b.loops()[i].old_keyframe_id) << i;
    ASSERT_EQ(a.loops()[i].T_old_kf.matrix(), b.loops()[i].T_old_kf.matrix()) << i;
  }
}

/// The owner's side: versions one after another.
class Owner {
 public:
  Owner(SourceId source, uint64_t seed) : source_(source), random_(seed) {}

  MapUpdate Next(int steps) {
    random_.Steps(steps);
    MapUpdate update = ChangedPart(random_.map(), random_.map().TakeChanges());
    update.Follow(version_++);
    update.source = source_;
    return update;
  }

  MapUpdate Whole() const {
    MapUpdate update = WholeMap(random_.map());
    update.version = version_;
    update.source = source_;
    return update;
  }

  const Map& map() const { return random_.map(); }

 private:
  SourceId source_;
  test::RandomMap random_;
  int64_t version_ = 0;
};

TEST(MapFollower, FollowsRandomChanges) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Owner owner(1, seed);
    MapFollower replica;
    for (int i = 0; i < 40; ++i) {
      const MapUpdate update = owner.Next(1 + i);
      ASSERT_EQ(replica.Apply(update), Step::kNext);
      ASSERT_EQ(update.totals, replica.map().Totals());
      ExpectSame(owner.map(), replica.map());
      if (HasFatalFailure()) return;
    }
  }
}

TEST(MapFollower, CorrectionIsSentAsPosesOnly) {
  test::RandomMap random(3);
  random.Steps(400);
  Map& map = random.map();
  MapUpdate whole = WholeMap(map);
  whole.version = 1;
  MapFollower replica;
  replica.Apply(whole);
  map.ForgetChanges();
  std::map<KeyframeId, SE3> poses;
  std::map<KeyframeId, Matrix6d> covariances;
  for (const auto& [id, keyframe] : map.keyframes()) {
    poses[id] = SE3(ExpSO3({0.01, 0.2, 0.0}), {1.0, 0.1 * static_cast<double>(id.value), 0.0}) * keyframe.T_w_kf;
    covariances[id] = 0.01 * Matrix6d::Identity();
  }
  map.Move(poses);
  map.SetCovariances(covariances);
  MapUpdate update = ChangedPart(map, map.TakeChanges());
  EXPECT_EQ(update.moved_keyframes.size(), map.keyframes().size());
  EXPECT_TRUE(update.keyframes.empty() && update.points.empty() && update.lines.empty());
  update.base_version = 1;
  update.version = 2;
  ASSERT_EQ(replica.Apply(update), Step::kNext);
  ExpectSame(map, replica.map());
}

TEST(Map, LandmarksMoveWithTheirMedianKeyframe) {
  Map map;
  for (int id = 0; id < 3; ++id) {
    MapKeyframe keyframe;
    keyframe.id = id;
    map.Put(keyframe);
  }
  MapPoint point;
  point.id = 0;
  point.p_w = {1.0, 2.0, 3.0};
  point.observations = {{0, 4}, {1, 4}, {2, 4}};
  map.Put(point);
  map.Move({{0, SE3(Eigen::Quaterniond::Identity(), {9.0, 9.0, 9.0})}});
  EXPECT_EQ(map.FindPoint(0)->p_w, Eigen::Vector3d(1.0, 2.0, 3.0));
  map.Move({{1, SE3(Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0})}});
  EXPECT_EQ(map.FindPoint(0)->p_w, Eigen::Vector3d(2.0, 2.0, 3.0));
}

TEST(MapFollower, GapIsDetectedAndFilledByTheWholeMap) {
  Owner owner(1, 5);
  MapFollower replica;
  replica.Apply(owner.Next(50));
  owner.Next(50);
  EXPECT_EQ(replica.Apply(owner.Next(50)), Step::kGap);
  EXPECT_EQ(replica.version()->number, 1);
  EXPECT_EQ(replica.Apply(owner.Whole()), Step::kNext);
  EXPECT_EQ(replica.version()->number, 3);
  EXPECT_EQ(replica.Apply(owner.Whole()), Step::kKnown) << "requested by another reader";
  EXPECT_EQ(replica.Apply(owner.Next(50)), Step::kNext);
  ExpectSame(owner.map(), replica.map());
}

TEST(MapFollower, LateReplicaNeedsTheWholeMap) {
  Owner owner(1, 6);
  owner.Next(50);
  MapFollower replica;
  EXPECT_EQ(replica.Apply(owner.Next(50)), Step::kGap);
  EXPECT_TRUE(replica.map().keyframes().empty());
  EXPECT_EQ(replica.Apply(owner.Whole()), Step::kNext);
  ExpectSame(owner.map(), replica.map());
}

TEST(MapFollower, MapOfARestartedMapperReplacesIt) {
  Owner before(1, 7), after(2, 8);
  MapFollower replica;
  replica.Apply(before.Next(100));
  replica.Apply(before.Next(100));
  EXPECT_EQ(replica.Apply(after.Next(20)), Step::kNext) << "its first version stands on nothing";
  ExpectSame(after.map(), replica.map());
  EXPECT_EQ(replica.Apply(before.Next(10)), Step::kGap);
  EXPECT_EQ(replica.Apply(after.Next(20)), Step::kNext);
  ExpectSame(after.map(), replica.map());
}

MapUpdate Newest(SessionId session, int64_t number, bool committed) {
  MapUpdate update;
  update.newest.session = session;
  update.newest.number = number;
  update.committed = committed;
  return update;
}

/// Version `version` of a map with keyframes 0, 1, 2 and 3 a metre apart along x, except those `removed`.
MapUpdate WholeRow(int64_t version, const std::set<KeyframeId>& removed) {
  Map map;
  for (int id = 0; id < 4; ++id) {
    MapKeyframe keyframe;
    keyframe.id = id;
    keyframe.frame_id = id;
    keyframe.previous_id = keyframe.parent_id = id - 1;
    keyframe.T_w_kf = SE3(Eigen::Quaterniond::Identity(), {1.0 * id, 0.0, 0.0});
    map.Put(keyframe);
  }
  for (const KeyframeId id : removed) map.RemoveKeyframe(id);
  MapUpdate update = WholeMap(map);
  update.source = 5;
  update.version = version;
  update.map_id.origin = 6;
  return update;
}

TEST(MapFollower, RemembersRemovedKeyframesOnRequest) {
  MapFollower replica, forgetful;
  replica.RememberRemoved();
  MapUpdate removal;
  removal.source = 5;
  removal.base_version = 1;
  removal.version = 2;
  removal.map_id.origin = 6;
  removal.removed_keyframes = {1, 2};
  for (MapFollower* each : {&replica, &forgetful}) {
    each->Apply(WholeRow(1, {}));
    EXPECT_EQ(each->Apply(removal), Step::kNext);
  }
  const std::vector<RemovedKeyframe> removed = replica.map().RemovedKeyframes();
  ASSERT_EQ(removed.size(), 2U);
  for (const RemovedKeyframe& keyframe : removed) {
    EXPECT_NEAR(keyframe.T_w_kf.translation().x(), static_cast<double>(keyframe.id.value), 1e-12);
  }
  EXPECT_TRUE(forgetful.map().RemovedKeyframes().empty());
}

TEST(MapFollower, WholeMapKeepsRememberedKeyframesOfTheSameMap) {
  MapFollower replica;
  replica.RememberRemoved();
  replica.Apply(WholeRow(1, {}));
  EXPECT_EQ(replica.Apply(WholeRow(7, {1, 2})), Step::kNext) << "versions were missed";
  EXPECT_EQ(replica.map().RemovedKeyframes().size(), 2U);
  EXPECT_EQ(replica.map().keyframes().size(), 2U);
  MapUpdate other = WholeRow(9, {3});
  other.map_id.origin = 8;
  EXPECT_EQ(replica.Apply(other), Step::kNext);
  EXPECT_TRUE(replica.map().RemovedKeyframes().empty()) << "they were of another map";
}

SE3 AtX(double x_m, double y_m = 0.0) { return {Eigen::Quaterniond::Identity(), {x_m, y_m, 0.0}}; }

/// A replica, and updates of the row of `WholeRow`.
class RemovedPosesTest : public testing::Test {
 protected:
  RemovedPosesTest() {
    follower_.RememberRemoved();
    follower_.Apply(WholeRow(1, {}));
  }

  MapUpdate Next() const {
    MapUpdate update;
    update.source = source_;
    update.map_id.origin = 6;
    update.Follow(follower_.version()->number);
    return update;
  }

  void Remove(KeyframeId id) {
    MapUpdate update = Next();
    update.removed_keyframes = {id};
    ASSERT_EQ(follower_.Apply(update), Step::kNext);
  }

  void AdjustLocally(KeyframeId id, const SE3& T_w_kf) {
    MapUpdate update = Next();
    update.keyframes = {*follower_.map().FindKeyframe(id)};
    update.keyframes.front().T_w_kf = T_w_kf;
    ASSERT_EQ(follower_.Apply(update), Step::kNext);
  }

  void CorrectAll(const SE3& T_new_old) {
    MapUpdate update = Next();
    for (const auto& [id, keyframe] : follower_.map().keyframes()) {
      update.moved_keyframes.push_back({id, T_new_old * keyframe.T_w_kf, keyframe.covariance});
    }
    ASSERT_EQ(follower_.Apply(update), Step::kNext);
  }

  /// Pose of a removed keyframe in the map.
  SE3 PoseOf(KeyframeId id) const {
    for (const RemovedKeyframe& keyframe : follower_.map().RemovedKeyframes()) {
      if (keyframe.id == id) return keyframe.T_w_kf;
    }
    throw std::out_of_range("not among the removed keyframes");
  }

  MapFollower follower_;
  SourceId source_ = 5;  ///< process that sends the updates
};

TEST_F(RemovedPosesTest, LocalAdjustmentsOfCarriersDoNotAddUp) {
  Remove(3);
  AdjustLocally(2, AtX(2.0, 0.1));
  Remove(2);
  AdjustLocally(1, AtX(1.0, 0.1));
  Remove(1);
  AdjustLocally(0, AtX(0.0, 0.1));
  EXPECT_LT((PoseOf(3).translation() - Eigen::Vector3d(3.0, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((PoseOf(2).translation() - Eigen::Vector3d(2.0, 0.1, 0.0)).norm(), 1e-12);
}

TEST_F(RemovedPosesTest, CorrectionMovesThemThroughRemovedCarriers) {
  CorrectAll(AtX(0.0, 5.0));
  Remove(3);
  CorrectAll(AtX(10.0));
  Remove(2);
  const SE3 turn(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0.0, 1.0, 0.0});
  CorrectAll(turn);
  const SE3 expected = turn * AtX(13.0, 5.0);
  EXPECT_LT((expected.Inverse() * PoseOf(3)).Log().norm(), 1e-12);
}

TEST_F(RemovedPosesTest, ForgottenCarriersLeaveThemInPlace) {
  CorrectAll(AtX(0.0, 5.0));
  Remove(3);
  CorrectAll(AtX(10.0));
  Remove(2);
  CorrectAll(AtX(0.0, 0.5));
  Remove(1);
  follower_.ForgetRemoved({1, 2});
  EXPECT_EQ(follower_.map().RemovedKeyframes().size(), 1U);
  EXPECT_LT((AtX(13.0, 5.5).Inverse() * PoseOf(3)).Log().norm(), 1e-12);
  const SE3 turn(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0.0, 1.0, 0.0});
  CorrectAll(turn);
  EXPECT_LT(((turn * AtX(13.0, 5.5)).Inverse() * PoseOf(3)).Log().norm(), 1e-12);
}

TEST_F(RemovedPosesTest, ReturningProcessRepeatsCorrectionsExactly) {
  const auto first = [this] {
    Remove(3);
    CorrectAll(AtX(0.1, 0.7));
  };
  const auto rest = [this] {
    AdjustLocally(2, AtX(2.3, 0.1));
    CorrectAll(AtX(0.3, 0.1));
    Remove(2);
    CorrectAll(AtX(0.9));
  };
  first();
  MapUpdate state = WholeMap(follower_.map());
  state.map_id.origin = 6;
  state.version = follower_.version()->number;
  rest();
  const SE3 T_w_2 = PoseOf(2), T_w_3 = PoseOf(3);
  state.source = 9;
  ASSERT_EQ(follower_.Apply(state), Step::kNext);
  EXPECT_LT((PoseOf(3).translation() - Eigen::Vector3d(3.1, 0.7, 0.0)).norm(), 1e-12) << "as in the state";
  source_ = 9;
  rest();
  EXPECT_EQ(PoseOf(2).translation(), T_w_2.translation());
  EXPECT_EQ(PoseOf(3).translation(), T_w_3.translation());
}

TEST_F(RemovedPosesTest, CarrierThatReturnsLeavesThemInPlace) {
  CorrectAll(AtX(0.0, 5.0));
  Remove(3);
  MapUpdate back = Next();
  back.keyframes = {*follower_.map().FindKeyframe(2)};
  Remove(2);
  back.Follow(follower_.version()->number);
  ASSERT_EQ(follower_.Apply(back), Step::kNext);
  EXPECT_LT((PoseOf(3).translation() - Eigen::Vector3d(3.0, 5.0, 0.0)).norm(), 1e-12);
}

TEST_F(RemovedPosesTest, MissedCorrectionIsThatOfTheCarrier) {
  Remove(3);
  MapUpdate later = WholeRow(9, {3});
  for (MapKeyframe& keyframe : later.keyframes) keyframe.T_w_kf = AtX(0.0, 2.0) * keyframe.T_w_kf;
  ASSERT_EQ(follower_.Apply(later), Step::kNext);
  EXPECT_LT((PoseOf(3).translation() - Eigen::Vector3d(3.0, 2.0, 0.0)).norm(), 1e-12);
}

TEST(MapFollower, ProcessOfUnknownMapBeginsAnother) {
  MapFollower replica;
  replica.RememberRemoved();
  MapUpdate first = WholeRow(1, {});
  first.map_id = {};
  replica.Apply(first);
  MapUpdate second = WholeRow(1, {1, 2});
  second.map_id = {};
  second.source = 9;
  EXPECT_EQ(replica.Apply(second), Step::kNext);
  EXPECT_TRUE(replica.map().RemovedKeyframes().empty());
}

TEST(Map, ReturningKeyframeIsNotRememberedTwice) {
  MapFollower replica;
  replica.RememberRemoved();
  replica.Apply(WholeRow(1, {}));
  replica.Apply(WholeRow(3, {3}));
  ASSERT_EQ(replica.map().RemovedKeyframes().size(), 1U);
  replica.Apply(WholeRow(5, {}));
  EXPECT_TRUE(replica.map().RemovedKeyframes().empty());
}

TEST(NewestKeyframes, UpdateCommitsKeyframesOfAllRobots) {
  NewestKeyframes committed;
  EXPECT_FALSE(committed.HasCommitted({1, 0}));
  committed.Add(Newest(1, 4, false));
  EXPECT_FALSE(committed.HasCommitted({1, 4}));
  committed.Add(Newest(2, 7, true));
  EXPECT_TRUE(committed.HasCommitted({1, 4}));
  EXPECT_TRUE(committed.HasCommitted({2, 7}));
  EXPECT_FALSE(committed.HasCommitted({1, 5}));
  committed.Add(Newest(1, 5, false));
  EXPECT_FALSE(committed.HasCommitted({1, 5}));
}

TEST(NewestKeyframes, RebuiltMapIsNotCommittedUntilComplete) {
  NewestKeyframes committed;
  committed.Add(Newest(1, 9, true));
  EXPECT_TRUE(committed.HasCommitted({1, 9}));
  committed.Add(Newest(1, 0, true));
  EXPECT_FALSE(committed.HasCommitted({1, 9}));
}

}  // namespace
}  // namespace plslam
