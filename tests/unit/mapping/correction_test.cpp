// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_follower.h"
#include "mapping_process/corrections/correction.h"
#include "mapping_process/mapper_state.h"
#include "tests/unit/mapping/loop_world.h"

namespace plslam::mapping {
namespace {

using test::Encoded;
using test::FeatureWorld;
using test::Revisit;
using test::Walk;

constexpr double kDriftedRadius_m = 6.0;
constexpr size_t kDriftedRound = 75;  // keyframes once round
constexpr size_t kBeyond = 5;         // keyframes of the second round that are mapped

struct DriftedWorld {
  std::string name;
  int points = 0;
  int lines = 0;
};

void PrintTo(const DriftedWorld& situation, std::ostream* stream) { *stream << situation.name; }

MappingOptions WithoutCulling() {
  MappingOptions options;
  options.culling.redundant_share = 1.01;
  return options;
}

/// A drifted map of a walk a little more than once round a ring.
struct Drifted {
  explicit Drifted(const DriftedWorld& situation)
      : world(test::MakeRing(kDriftedRadius_m, situation.points, situation.lines, 3)),
        walk(test::MakeWalk(world, test::RingPath(kDriftedRadius_m, 0.5, kDriftedRound + 2 * kBeyond), {})),
        mapper(FeatureWorld::Camera(), WithoutCulling()) {
    // The tracker has long dropped its first landmarks.
    for (size_t i = kDriftedRound / 2; i < walk.keyframes.size(); ++i) {
      for (TrackId& id : walk.keyframes[i].point_landmark_ids) id.value += 1'000'000;
      for (TrackId& id : walk.keyframes[i].line_landmark_ids) id.value += 1'000'000;
    }
    for (size_t i = 0; i < kDriftedRound + kBeyond; ++i) test::MapOne(walk.keyframes[i], mapper);
    std::string reason;
    EXPECT_TRUE(mapper.Correct(test::Drift(mapper.map()), &reason)) << reason;
  }

  FeatureWorld world;
  Walk walk;
  Mapper mapper;
};

/// Each test has a copy: making one takes longer than most tests.
const Drifted& DriftedMap(const DriftedWorld& situation) {
  static std::map<std::string, Drifted> made;
  return made.try_emplace(situation.name, situation).first->second;
}

class Correction : public testing::TestWithParam<DriftedWorld> {
 protected:
  void MapNext() { EXPECT_TRUE(test::MapOne(walk_.keyframes[n_mapped_++], mapper_, &reason_)) << reason_; }
  LoopClosure Loop() const { return test::CloseByTruth(mapper_.map(), revisit_, walk_.T_w_c); }
  double Error_m() const { return test::PositionError_m(mapper_.map(), walk_.T_w_c); }
  double Reprojection_px() const { return test::Reprojection_px(mapper_.map(), walk_.keyframes); }
  const MapKeyframe& KeyframeOf(KeyframeId id) const { return *mapper_.map().FindKeyframe(id); }
  KeyframeId Newest() const { return mapper_.map().keyframes().rbegin()->first; }

  const FeatureWorld& world_ = DriftedMap(GetParam()).world;
  const Walk& walk_ = DriftedMap(GetParam()).walk;
  Mapper mapper_ = DriftedMap(GetParam()).mapper;
  size_t n_mapped_ = kDriftedRound + kBeyond;
  const Revisit revisit_ = test::RevisitOf(mapper_.map(), walk_.T_w_c);
  std::string reason_;
};

TEST_P(Correction, ALoopIsClosed) {
  const double error_m = Error_m();
  const int duplicates = test::Duplicates(mapper_.map());
  ASSERT_GT(error_m, 0.2);
  ASSERT_GT(duplicates, 20);
  ASSERT_EQ(mapper_.map().Shared(revisit_.old_keyframe_id, revisit_.keyframe_id), 0);
  ASSERT_TRUE(mapper_.Correct(Loop(), &reason_)) << reason_;
  ASSERT_EQ(test::WrongWith(mapper_.map()), "");
  ASSERT_EQ(test::ExactlyKnown(mapper_.map()), 0);
  EXPECT_LT(Error_m(), error_m / 5.0);
  EXPECT_LT(test::Duplicates(mapper_.map()), duplicates / 3);
  EXPECT_LT(Reprojection_px(), 1.5);
  EXPECT_GE(mapper_.map().Shared(revisit_.old_keyframe_id, revisit_.keyframe_id), Map::kCovisible);
  // Both sides are one neighbourhood, not only the two keyframes of the edge.
  EXPECT_GE(mapper_.map().Shared(revisit_.old_keyframe_id, KeyframeId(revisit_.keyframe_id.value - 1)),
            Map::kCovisible);
  EXPECT_GE(mapper_.map().Shared(KeyframeId(revisit_.old_keyframe_id.value + 1), revisit_.keyframe_id), 15);
  ASSERT_EQ(mapper_.map().loops().size(), 1U);
  EXPECT_EQ(mapper_.map().loops().front().keyframe_id, revisit_.keyframe_id);
}

// The landmarks that are not in the message are found only by search.
TEST_P(Correction, ALoopWithoutPairsIsClosedToo) {
  LoopClosure closure = Loop();
  closure.points.clear();
  closure.lines.clear();
  const int duplicates = test::Duplicates(mapper_.map());
  ASSERT_TRUE(mapper_.Correct(closure, &reason_)) << reason_;
  ASSERT_EQ(test::WrongWith(mapper_.map()), "");
  EXPECT_LT(test::Duplicates(mapper_.map()), duplicates / 3);
  EXPECT_GE(mapper_.map().Shared(revisit_.old_keyframe_id, revisit_.keyframe_id), Map::kCovisible);
}

TEST_P(Correction, KeyframesAfterALoopMatchTheOldPart) {
  Mapper open = mapper_;
  ASSERT_TRUE(mapper_.Correct(Loop(), &reason_)) << reason_;
  const double error_m = Error_m();
  const auto landmarks = [](const Mapper& mapper) {
    return static_cast<int>(mapper.map().points().size() + mapper.map().lines().size());
  };
  const int n_closed = landmarks(mapper_);
  const int n_open = landmarks(open);
  for (size_t i = 0; i < kBeyond; ++i) {
    ASSERT_TRUE(test::MapOne(walk_.keyframes[n_mapped_], open, &reason_)) << reason_;
    MapNext();
    ASSERT_EQ(test::WrongWith(mapper_.map()), "");
    const auto neighbours = mapper_.map().Neighbours(Newest(), 15);
    const auto old = [](const Map::Neighbour& neighbour) {
      return neighbour.keyframe_id.value < int64_t{kDriftedRound / 2};
    };
    EXPECT_TRUE(std::any_of(neighbours.begin(), neighbours.end(), old)) << Newest();
  }
  EXPECT_LT(Error_m(), 1.5 * error_m + 0.01);
  // Only landmarks that come into view far away are mapped again.
  EXPECT_LT(landmarks(mapper_) - n_closed, landmarks(open) - n_open);
}

TEST_P(Correction, NewerKeyframesAreCorrectedToo) {
  const LoopClosure closure = Loop();
  for (int i = 0; i < 3; ++i) MapNext();
  const double error_m = Error_m();
  std::vector<SE3> before;
  for (int i = 0; i < 3; ++i) {
    const MapKeyframe& keyframe = KeyframeOf(KeyframeId(revisit_.keyframe_id.value + 1 + i));
    before.push_back(KeyframeOf(keyframe.parent_id).T_w_kf.Inverse() * keyframe.T_w_kf);
  }
  const std::map<KeyframeId, SE3> poses = PosesAfter(closure.poses, mapper_.map());
  for (int i = 0; i < 3; ++i) {
    const MapKeyframe& keyframe = KeyframeOf(KeyframeId(revisit_.keyframe_id.value + 1 + i));
    const SE3 after = poses.at(keyframe.parent_id).Inverse() * poses.at(keyframe.id);
    EXPECT_LT((before[static_cast<size_t>(i)].Inverse() * after).Log().norm(), 1e-12);
  }
  ASSERT_TRUE(mapper_.Correct(closure, &reason_)) << reason_;
  ASSERT_EQ(test::WrongWith(mapper_.map()), "");
  EXPECT_LT(Error_m(), error_m / 4.0);
}

// A map that culls keyframes between the closure's version and the closure.
TEST_P(Correction, KeyframesCulledSinceAreLeftOut) {
  MappingOptions options;
  options.culling.redundant_share = 0.6;
  Mapper mapper(FeatureWorld::Camera(), options);
  const auto map = [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) ASSERT_TRUE(test::MapOne(walk_.keyframes[i], mapper, &reason_)) << reason_;
  };
  map(0, kDriftedRound + kBeyond);
  ASSERT_TRUE(mapper.Correct(test::Drift(mapper.map()), &reason_)) << reason_;
  const double error_m = test::PositionError_m(mapper.map(), walk_.T_w_c);
  const Revisit revisit = test::RevisitOf(mapper.map(), walk_.T_w_c);
  const LoopClosure closure = test::CloseByTruth(mapper.map(), revisit, walk_.T_w_c);
  map(kDriftedRound + kBeyond, kDriftedRound + 2 * kBeyond);
  const auto is_gone = [&](const CorrectedPose& pose) {
    return mapper.map().FindKeyframe(pose.keyframe_id) == nullptr;
  };
  ASSERT_GT(std::count_if(closure.poses.begin(), closure.poses.end(), is_gone), 0);
  ASSERT_TRUE(mapper.Correct(closure, &reason_)) << reason_;
  ASSERT_EQ(test::WrongWith(mapper.map()), "");
  EXPECT_LT(test::PositionError_m(mapper.map(), walk_.T_w_c), error_m / 5.0);
  // It ties keyframes of this map, as they lie.
  ASSERT_EQ(mapper.map().loops().size(), 1U);
  const LoopEdge& loop = mapper.map().loops().front();
  ASSERT_NE(mapper.map().FindKeyframe(loop.old_keyframe_id), nullptr);
  ASSERT_NE(mapper.map().FindKeyframe(loop.keyframe_id), nullptr);
  const SE3 T_old_kf = mapper.map().FindKeyframe(loop.old_keyframe_id)->T_w_kf.Inverse() *
                       mapper.map().FindKeyframe(loop.keyframe_id)->T_w_kf;
  EXPECT_LT((loop.T_old_kf.Inverse() * T_old_kf).Log().norm(), 0.1);
  ASSERT_TRUE(mapper.Correct(test::AdjustByTruth(mapper.map(), walk_.T_w_c), &reason_)) << reason_;
  EXPECT_EQ(test::WrongWith(mapper.map()), "");
}

TEST_P(Correction, ReplicaOfTheUpdatesIsEqual) {
  MapFollower replica;
  ASSERT_EQ(replica.Apply(mapper_.TakeUpdate()), MapStep::kNext);
  ASSERT_TRUE(mapper_.Correct(Loop(), &reason_)) << reason_;
  ASSERT_EQ(replica.Apply(mapper_.TakeUpdate()), MapStep::kNext);
  EXPECT_EQ(Encoded(replica.map()), Encoded(mapper_.map()));
  ASSERT_TRUE(mapper_.Correct(test::AdjustByTruth(mapper_.map(), walk_.T_w_c), &reason_)) << reason_;
  ASSERT_EQ(replica.Apply(mapper_.TakeUpdate()), MapStep::kNext);
  EXPECT_EQ(Encoded(replica.map()), Encoded(mapper_.map()));
}

TEST_P(Correction, EqualInputGivesEqualBytes) {
  Mapper other = mapper_;
  const LoopClosure closure = Loop();
  ASSERT_TRUE(mapper_.Correct(closure, &reason_)) << reason_;
  ASSERT_TRUE(other.Correct(closure, &reason_)) << reason_;
  EXPECT_EQ(Encoded(other.map()), Encoded(mapper_.map()));
}

TEST_P(Correction, AdjustmentRetriangulatesTheLandmarks) {
  ASSERT_TRUE(mapper_.Correct(Loop(), &reason_)) << reason_;
  const MapTotals before = mapper_.map().Totals();
  ASSERT_TRUE(mapper_.Correct(test::AdjustByTruth(mapper_.map(), walk_.T_w_c), &reason_)) << reason_;
  ASSERT_EQ(test::WrongWith(mapper_.map()), "");
  ASSERT_EQ(test::ExactlyKnown(mapper_.map()), 0);
  EXPECT_LT(Error_m(), 1e-9);
  EXPECT_LT(Reprojection_px(), 0.7);
  // Observations that disagree go; there are few where poses are true.
  const MapTotals after = mapper_.map().Totals();
  EXPECT_GT(after.point_observations + after.line_observations,
            (before.point_observations + before.line_observations) * 95 / 100);
  const auto check = [](const std::vector<double>& errors_m, double median_m) {
    if (errors_m.empty()) return;
    EXPECT_LT(errors_m[errors_m.size() / 2], median_m);
  };
  check(test::PointErrors_m(mapper_.map(), world_), 0.03);
  check(test::LineErrors_m(mapper_.map(), world_), 0.08);
}

// A correction that is rejected, and a word that its sentence must contain.
struct Refusal {
  std::function<void(LoopClosure&)> spoil;
  std::string named;
};

TEST_P(Correction, InvalidClosureLeavesTheMapUnchanged) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Refusal> refusals = {
      {[](LoopClosure& c) { c.poses[5].keyframe_id = 100'000; }, "100000"},
      {[](LoopClosure& c) { c.poses[0].keyframe_id = -1; }, "-1"},
      {[](LoopClosure& c) { std::swap(c.poses[3], c.poses[4]); }, "ascending"},
      {[&](LoopClosure& c) {
         c.poses[7].T_w_kf = SE3::FromUnit({1, 0, 0, 0}, {0, nan, 0});
       },
       "is invalid"},
      {[](LoopClosure& c) {
         c.poses[7].T_w_kf = SE3::FromUnit({1, 0, 0, 0}, {0, 1e300, 0});
       },
       "is invalid"},
      {[](LoopClosure& c) {
         c.poses[7].T_w_kf = SE3::FromUnit({0, 0, 0, 0}, {0, 0, 0});
       },
       "is invalid"},
      {[](LoopClosure& c) {
         c.poses[7].T_w_kf = SE3::FromUnit({2, 0, 0, 0}, {0, 0, 0});
       },
       "is invalid"},
      {[](LoopClosure& c) { c.edges.clear(); }, "has no edges"},
      {[](LoopClosure& c) { c.edges[0].keyframe_id = 5'000; }, "5000"},
      {[](LoopClosure& c) { c.edges[0].keyframe_id = c.edges[0].old_keyframe_id; }, "its loop joins"},
      {[&](LoopClosure& c) {
         c.edges[0].T_old_kf = SE3::FromUnit({nan, 0, 0, 0}, {0, 0, 0});
       },
       "is invalid"},
      {[](LoopClosure& c) { c.edges[0].covariance.setZero(); }, "covariance"},
      {[&](LoopClosure& c) { c.edges[0].covariance(2, 2) = nan; }, "covariance"},
      {[](LoopClosure& c) {
         c.points = {{0, 77'000}};
       },
       "points 0 and 77000"},
      {[](LoopClosure& c) {
         c.lines = {{-3, 0}};
       },
       "lines -3 and 0"},
      {[](LoopClosure& c) {
         c.map_version = {{}, {}, 1'000};
       },
       "version 1000"},
      {[](LoopClosure& c) {
         c.map_version = {{{}, 1}, {}, 1};
       },
       "another map"},
      {[](LoopClosure& c) {
         c.kind = LoopClosure::Kind::kAdjustment;
         c.poses.clear();
         c.edges.clear();
       },
       "none of its keyframes"}};
  mapper_.TakeUpdate();
  const std::vector<uint8_t> before = Encoded(mapper_.map());
  for (const Refusal& refusal : refusals) {
    LoopClosure closure = Loop();
    refusal.spoil(closure);
    ASSERT_FALSE(mapper_.Correct(closure, &reason_)) << refusal.named;
    EXPECT_NE(reason_.find(refusal.named), std::string::npos) << reason_;
    EXPECT_EQ(Encoded(mapper_.map()), before) << reason_;
  }
  const MapUpdate nothing = mapper_.TakeUpdate();
  EXPECT_TRUE(nothing.keyframes.empty() && nothing.points.empty() && nothing.lines.empty() && nothing.loops.empty());
}

TEST_P(Correction, EmptyClosureChangesNothing) {
  LoopClosure closure = Loop();
  closure.kind = LoopClosure::Kind::kNone;
  const std::vector<uint8_t> before = Encoded(mapper_.map());
  EXPECT_TRUE(mapper_.Correct(closure, &reason_));
  EXPECT_EQ(Encoded(mapper_.map()), before);
}

TEST_P(Correction, UpdatesFlagTheCommittedKeyframe) {
  EXPECT_FALSE(mapper_.TakeUpdate().committed);
  mapper_.Commit();
  EXPECT_TRUE(mapper_.TakeUpdate().committed);
  EXPECT_TRUE(mapper_.Whole().committed);
  MapNext();
  EXPECT_FALSE(mapper_.TakeUpdate().committed);
  EXPECT_FALSE(mapper_.Whole().committed);
}

std::string NameOfWorld(const testing::TestParamInfo<DriftedWorld>& situation) { return situation.param.name; }

INSTANTIATE_TEST_SUITE_P(Kinds, Correction,
                         testing::Values(DriftedWorld{"Points", 600, 0}, DriftedWorld{"Lines", 0, 400},
                                         DriftedWorld{"Both", 500, 120}),
                         NameOfWorld);

// In live mode, a global bundle adjustment that was running when a loop was found arrives after it, or two parts of the
// map are joined while a loop is on its way.
TEST_P(Correction, CorrectionOfAnOlderMapStructureIsRefused) {
  mapper_.TakeUpdate();
  LoopClosure older = test::AdjustByTruth(mapper_.map(), walk_.T_w_c);
  for (CorrectedPose& pose : older.poses) pose.T_w_kf = KeyframeOf(pose.keyframe_id).T_w_kf;
  LoopClosure loop = Loop();
  older.map_version = loop.map_version = MapVersion{{}, {}, mapper_.version()};
  ASSERT_TRUE(mapper_.Correct(loop, &reason_)) << reason_;
  mapper_.TakeUpdate();
  const auto closed = Encoded(mapper_.map());
  EXPECT_FALSE(mapper_.Correct(older, &reason_));
  EXPECT_NE(reason_.find("structure"), std::string::npos) << reason_;
  EXPECT_EQ(Encoded(mapper_.map()), closed);
  EXPECT_FALSE(mapper_.Correct(loop, &reason_)) << "another loop found on that map would undo the first one";
  EXPECT_NE(reason_.find("structure"), std::string::npos) << reason_;
  EXPECT_EQ(Encoded(mapper_.map()), closed);
  Mapper restored(FeatureWorld::Camera(), WithoutCulling(), DecodeState(EncodeState(mapper_.State())));
  EXPECT_FALSE(restored.Correct(older, &reason_));
  LoopClosure newer = test::AdjustByTruth(mapper_.map(), walk_.T_w_c);
  newer.map_version = MapVersion{{}, {}, mapper_.version()};
  EXPECT_TRUE(mapper_.Correct(newer, &reason_)) << reason_;
}

}  // namespace
}  // namespace plslam::mapping
