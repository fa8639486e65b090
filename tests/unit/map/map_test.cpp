// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/map/map.h"
#include "tests/unit/map/random_map.h"

namespace plslam {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

MapKeyframe KeyframeOf(KeyframeId id, KeyframeId parent_id) {
  MapKeyframe keyframe;
  keyframe.id = id;
  keyframe.parent_id = parent_id;
  return keyframe;
}

MapPoint PointOf(LandmarkId id, std::vector<Observation> observations) {
  MapPoint point;
  point.id = id;
  point.observations = std::move(observations);
  return point;
}

MapLine LineOf(LandmarkId id, std::vector<Observation> observations) {
  MapLine line;
  line.id = id;
  line.observations = std::move(observations);
  return line;
}

/// Keyframes 0, 1, 2, each the parent of the next.
Map Chain() {
  Map map;
  for (int id = 0; id < 3; ++id) map.Put(KeyframeOf(id, id - 1));
  return map;
}

using PairCounts = std::map<std::pair<KeyframeId, KeyframeId>, int>;

/// Slow twin of the covisibility counts: every pair of observations of every landmark.
template <class Landmark>
void Recount(const IdMap<LandmarkId, Landmark>& landmarks, PairCounts& counts) {
  for (const auto& [id, landmark] : landmarks) {
    for (const Observation& a : landmark.observations) {
      for (const Observation& b : landmark.observations) {
        if (a.keyframe_id() != b.keyframe_id()) ++counts[{a.keyframe_id(), b.keyframe_id()}];
      }
    }
  }
}

/// Slow twin of the tables from features to landmarks, and of the number of observations.
template <class Landmark>
void ExpectTables(const Map& map, const IdMap<LandmarkId, Landmark>& landmarks,
                  std::vector<LandmarkId> Map::FeatureLandmarks::*of, int64_t n_observations) {
  std::map<Observation, LandmarkId, decltype([](const Observation& a, const Observation& b) {
             return std::pair(a.keyframe_id(), a.feature) < std::pair(b.keyframe_id(), b.feature);
           })>
      owners;
  for (const auto& [id, landmark] : landmarks) {
    for (const Observation& observation : landmark.observations) {
      ASSERT_TRUE(owners.emplace(observation, id).second)
          << "feature " << observation.feature << " of keyframe " << observation.keyframe_id() << " belongs to two";
    }
  }
  ASSERT_EQ(static_cast<int64_t>(owners.size()), n_observations);
  size_t found = 0;
  for (const auto& [keyframe_id, keyframe] : map.keyframes()) {
    const std::vector<LandmarkId>& table = map.LandmarksOf(keyframe_id).*of;
    for (size_t feature = 0; feature < table.size(); ++feature) {
      const auto owner = owners.find({keyframe_id, static_cast<int32_t>(feature)});
      ASSERT_EQ(table[feature], owner == owners.end() ? -1 : owner->second) << keyframe_id << " " << feature;
      found += table[feature] >= 0 ? 1 : 0;
    }
  }
  ASSERT_EQ(found, owners.size());
}

void ExpectCounts(const Map& map) {
  PairCounts counts;
  Recount(map.points(), counts);
  Recount(map.lines(), counts);
  for (const auto& [a, keyframe_a] : map.keyframes()) {
    size_t neighbours = 0;
    for (const auto& [b, keyframe_b] : map.keyframes()) {
      const auto count = counts.find({a, b});
      ASSERT_EQ(map.Shared(a, b), count == counts.end() ? 0 : count->second) << a << " " << b;
      neighbours += count == counts.end() ? 0 : 1;
    }
    ASSERT_EQ(map.Neighbours(a, 1).size(), neighbours) << a;
  }
}

void ExpectTree(const Map& map) {
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id == map.keyframes().begin()->first) {
      ASSERT_EQ(keyframe.parent_id, -1);
    } else {
      ASSERT_LT(keyframe.parent_id, id);
      ASSERT_NE(map.FindKeyframe(keyframe.parent_id), nullptr) << id << " hangs on " << keyframe.parent_id;
    }
    std::vector<KeyframeId> children;
    for (const auto& [other_id, other] : map.keyframes()) {
      if (other.parent_id == id) children.push_back(other_id);
    }
    ASSERT_EQ(map.Children(id), children) << id;
  }
}

TEST(Map, TablesAgreeWithASlowRecount) {
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::RandomMap random(seed);
    for (int i = 0; i < 40; ++i) {
      random.Steps(10);
      const Map& map = random.map();
      const MapTotals totals = map.Totals();
      ExpectCounts(map);
      ExpectTables(map, map.points(), &Map::FeatureLandmarks::points, totals.point_observations);
      ExpectTables(map, map.lines(), &Map::FeatureLandmarks::lines, totals.line_observations);
      ExpectTree(map);
      if (HasFatalFailure()) return;
    }
    EXPECT_GT(random.map().Totals().point_observations, 20) << "nothing was tested";
  }
}

TEST(Map, FeatureBelongsToTheLatestLandmark) {
  Map map = Chain();
  map.Put(PointOf(0, {{0, 5}, {1, 6}}));
  map.Put(PointOf(1, {{1, 6}, {2, 7}}));
  EXPECT_THAT(map.FindPoint(0)->observations, ElementsAre(Observation{0, 5}));
  EXPECT_EQ(map.LandmarksOf(1).points[6], 1);
  EXPECT_EQ(map.Shared(0, 1), 0);
  EXPECT_EQ(map.Shared(1, 2), 1);
}

TEST(Map, PointsAndLinesOfTheSameNumberAreApart) {
  Map map = Chain();
  map.Put(PointOf(0, {{0, 1}, {1, 1}}));
  map.Put(LineOf(0, {{0, 1}, {1, 1}}));
  EXPECT_EQ(map.Shared(0, 1), 2);
  map.RemoveLine(0);
  EXPECT_EQ(map.Shared(0, 1), 1);
  EXPECT_NE(map.FindPoint(0), nullptr);
}

TEST(Map, NeighboursAreSortedBySharedLandmarks) {
  Map map = Chain();
  map.Put(PointOf(0, {{0, 0}, {2, 0}}));
  map.Put(PointOf(1, {{0, 1}, {1, 0}, {2, 1}}));
  EXPECT_THAT(map.Neighbours(2, 1), ElementsAre(Map::Neighbour{0, 2}, Map::Neighbour{1, 1}));
  EXPECT_THAT(map.Neighbours(2, 2), ElementsAre(Map::Neighbour{0, 2}));
  EXPECT_THAT(map.Neighbours(9, 1), IsEmpty());
}

TEST(Map, RemovedKeyframeLeavesNoObservations) {
  Map map = Chain();
  map.Put(KeyframeOf(3, 1));
  map.Put(PointOf(0, {{1, 0}}));
  map.Put(PointOf(1, {{0, 0}, {1, 1}}));
  for (int i = 0; i < Map::kParent; ++i) map.Put(PointOf(2 + i, {{2, i}, {3, i}}));
  map.TakeChanges();
  map.RemoveKeyframe(1);
  EXPECT_EQ(map.FindPoint(0), nullptr) << "no keyframe observes it";
  EXPECT_THAT(map.FindPoint(1)->observations, ElementsAre(Observation{0, 0}));
  EXPECT_EQ(map.FindKeyframe(2)->parent_id, 0) << "no older neighbour: the parent of the parent";
  EXPECT_EQ(map.FindKeyframe(3)->parent_id, 2) << "its best neighbour";
  const MapChanges changes = map.TakeChanges();
  EXPECT_THAT(changes.removed_keyframes, ElementsAre(1));
  EXPECT_THAT(changes.keyframes, ElementsAre(2, 3));
  EXPECT_THAT(changes.removed_points, ElementsAre(0));
  EXPECT_THAT(changes.points, ElementsAre(1));
  EXPECT_TRUE(map.TakeChanges().empty());
}

TEST(Map, ChangesReportTheFinalState) {
  Map map = Chain();
  map.Put(PointOf(0, {{0, 0}}));
  map.Put(PointOf(1, {{0, 1}}));
  map.TakeChanges();
  map.RemovePoint(1);
  map.Put(PointOf(1, {{0, 1}}));
  map.Put(PointOf(1, {{1, 1}}));
  map.Put(PointOf(2, {{0, 2}}));
  map.RemovePoint(2);
  const MapChanges changes = map.TakeChanges();
  EXPECT_THAT(changes.points, ElementsAre(1));
  EXPECT_THAT(changes.removed_points, ElementsAre(2));
}

TEST(Map, LoopsAreRemovedWithTheirKeyframes) {
  const auto loop = [](int old_id, int id) {
    LoopEdge edge;
    edge.old_keyframe_id = old_id;
    edge.keyframe_id = id;
    return edge;
  };
  const auto newer_ends = [](const std::vector<LoopEdge>& loops) {
    std::vector<KeyframeId> ids;
    for (const LoopEdge& edge : loops) ids.push_back(edge.keyframe_id);
    return ids;
  };
  Map map = Chain();
  map.Put(KeyframeOf(3, 2));
  map.Add(loop(0, 3));
  map.Add(loop(0, 77));
  map.TakeChanges();
  map.Add(loop(1, 3));
  map.Add(loop(0, 2));
  EXPECT_THAT(newer_ends(map.loops()), ElementsAre(2, 3, 3)) << "also those that an older keyframe has taken over";
  map.RemoveKeyframe(1);
  EXPECT_THAT(newer_ends(map.loops()), ElementsAre(2, 3));
  EXPECT_THAT(newer_ends(map.TakeChanges().loops), ElementsAre(2));
  map.RemoveKeyframe(3);
  EXPECT_THAT(newer_ends(map.loops()), ElementsAre(2));
  EXPECT_TRUE(map.TakeChanges().loops.empty());
}

TEST(Map, AFalseLandmarkIsNoParent) {
  Map map = Chain();
  map.Put(KeyframeOf(3, 2));
  for (int i = 0; i + 1 < Map::kParent; ++i) map.Put(PointOf(i, {{0, i}, {3, i}}));
  map.RemoveKeyframe(2);
  EXPECT_EQ(map.FindKeyframe(3)->parent_id, 1) << "the parent of the parent";
}

TEST(Map, ObservationsOfUnknownKeyframesAreIgnored) {
  Map map = Chain();
  map.Put(PointOf(0, {{1, 0}, {77, 0}}));
  EXPECT_THAT(map.FindPoint(0)->observations, ElementsAre(Observation{1, 0}));
}

TEST(Map, InvalidObservationsAreRefused) {
  Map map = Chain();
  EXPECT_THROW(map.Put(PointOf(0, {{1, 0}, {0, 0}})), std::invalid_argument);
  EXPECT_THROW(map.Put(PointOf(0, {{1, 0}, {1, 1}})), std::invalid_argument);
  EXPECT_THROW(map.Put(LineOf(0, {{1, -1}})), std::invalid_argument);
  EXPECT_TRUE(map.points().empty());
}

TEST(Map, PutOfItsOwnElementChangesNothing) {
  Map map = Chain();
  map.Put(PointOf(0, {{0, 5}, {1, 6}}));
  map.Put(*map.FindPoint(0));
  map.Put(*map.FindKeyframe(1));
  EXPECT_EQ(map.FindPoint(0)->observations.size(), 2U);
  EXPECT_EQ(map.Shared(0, 1), 1);
  EXPECT_THAT(map.Children(0), ElementsAre(1));
}

}  // namespace

namespace {

using Counts = std::vector<SharedCounts::Count>;

Counts All(const SharedCounts& counts) { return {counts.begin(), counts.end()}; }

TEST(SharedCounts, AscendByKeyframeForAnyOrder) {
  SharedCounts counts;
  for (const int id : {7, 3, 9, 3, 7, 3}) counts.Add(id, 1);
  EXPECT_EQ(All(counts), (Counts{{3, 3}, {7, 2}, {9, 1}}));
  EXPECT_EQ(counts.Of(3), 3);
  EXPECT_EQ(counts.Of(4), 0);
  EXPECT_EQ(counts.Of(10), 0);
}

TEST(SharedCounts, KeyframesSharingNothingAreRemoved) {
  SharedCounts counts;
  counts.Add(5, 1);
  counts.Add(6, 2);
  counts.Add(5, -1);
  counts.Add(6, -1);
  EXPECT_EQ(All(counts), (Counts{{6, 1}}));
}

}  // namespace
}  // namespace plslam
