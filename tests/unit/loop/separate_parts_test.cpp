// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "loop_process/loop_closer.h"
#include "tests/unit/loop/ring_world.h"

// Maps of which a part lies in a frame of its own, because nothing connects it with the rest yet.

namespace plslam::test {
namespace {

constexpr int64_t kOtherSession = 8;
// The part that came first is a copy of these of the other.
constexpr int64_t kCopied = 12;
// What the rest of the map begins with.
constexpr int64_t kFirstId = 1000;
constexpr int64_t kFirstLandmark = 1000000;

int64_t Shifted(int64_t id, int64_t by) { return id < 0 ? -1 : id + by; }

std::vector<Observation> ShiftedObservations(std::vector<Observation> observations, int64_t by) {
  for (Observation& observation : observations) observation.keyframe_id += by;
  return observations;
}

void PutKeyframes(const Map& from, int64_t n, int64_t shift, int64_t session, const SE3& T_new_old, Map& to) {
  for (const auto& [id, keyframe] : from.keyframes()) {
    if (id >= n) break;
    MapKeyframe put = keyframe;
    put.id += shift;
    put.session = session;
    put.previous_id = Shifted(put.previous_id, shift);
    put.parent_id = Shifted(put.parent_id, shift);
    put.T_w_kf = T_new_old * keyframe.T_w_kf;
    to.Put(put);
  }
}

// Of those of which keyframes have come.
void PutLandmarks(const Map& from, int64_t n, int64_t shift, int64_t landmark_shift, const SE3& T_new_old, Map& to) {
  const auto is_of_others = [n](const Observation& observation) { return observation.keyframe_id >= n; };
  for (const auto& [id, point] : from.points()) {
    MapPoint put = point;
    put.id += landmark_shift;
    std::erase_if(put.observations, is_of_others);
    put.observations = ShiftedObservations(put.observations, shift);
    put.p_w = T_new_old * point.p_w;
    if (!put.observations.empty()) to.Put(put);
  }
  for (const auto& [id, line] : from.lines()) {
    MapLine put = line;
    put.id += landmark_shift;
    std::erase_if(put.observations, is_of_others);
    put.observations = ShiftedObservations(put.observations, shift);
    put.segment_w = {T_new_old * line.segment_w.p, T_new_old * line.segment_w.q};
    if (!put.observations.empty()) to.Put(put);
  }
}

/// A lap of the ring, and its beginning once more as another session that came before, with an origin of its own.
struct TwoParts {
  Map map;
  loop::LoopCloser closer;
  int64_t newest = -1;  ///< as its session counts; the first whose loop is found where there is nothing but the lap

  explicit TwoParts(const Ring& ring) : closer(FeatureWorld::Camera(), PlacesOf(ring.world), {}) {
    Closing lap(PlacesOf(ring.world), {});
    for (const Keyframe& keyframe : ring.walk.keyframes) {
      closer.AddKeyframe(keyframe);
      newest = keyframe.keyframe_id;
      if (lap.Show(keyframe).kind == LoopClosure::Kind::kLoop) break;
    }
    for (Keyframe keyframe : std::vector(ring.walk.keyframes.begin(), ring.walk.keyframes.begin() + kCopied)) {
      keyframe.session = kOtherSession;
      closer.AddKeyframe(keyframe);
    }
    const Map& whole = lap.mapper.map();
    const SE3 T_own_w(ExpSO3({0.1, 0.7, 0.0}), {3.0, 1.0, -2.0});
    PutKeyframes(whole, kCopied, 0, kOtherSession, T_own_w, map);
    PutKeyframes(whole, newest + 1, kFirstId, ring.walk.keyframes.front().session, SE3(), map);
    PutLandmarks(whole, kCopied, 0, 0, T_own_w, map);
    PutLandmarks(whole, newest + 1, kFirstId, kFirstLandmark, SE3(), map);
  }
};

bool SeesFirstPart(const loop::LoopEvidence& evidence) { return evidence.edge.old_keyframe_id < kFirstId; }

TEST(SeparateParts, WhatAnotherPartShowsDoesNotContradictALoop) {
  const Ring ring;
  TwoParts parts(ring);
  const LoopClosure loop = parts.closer.Check(parts.map, ring.walk.keyframes.front().session, parts.newest);
  const loop::LoopSearch& search = parts.closer.last_search();
  ASSERT_TRUE(std::any_of(search.evidence.begin(), search.evidence.end(), [](const loop::LoopEvidence& evidence) {
    return SeesFirstPart(evidence) && evidence.place.inliers > 40;
  })) << "the other part shows the place too";
  ASSERT_EQ(loop.kind, LoopClosure::Kind::kLoop);
  EXPECT_TRUE(search.evidence[*search.best].connected) << "drift has been asked";
  EXPECT_GE(loop.edges.front().old_keyframe_id, kFirstId);
  EXPECT_EQ(loop.poses.front().keyframe_id, kFirstId) << "of the other part nothing is said";
}

TEST(SeparateParts, ACameraIsFoundInEither) {
  const Ring ring;
  TwoParts parts(ring);
  parts.closer.Follow(parts.map);
  const SE3 T_w_c = ring.walk.T_w_c[3] * SE3(ExpSO3({0.02, 0.05, -0.03}), {0.05, -0.05, 0.1});
  const Relocalisation answer = parts.closer.Relocalise(parts.map, ring.world.Observe(T_w_c, 0.4, 77));
  ASSERT_TRUE(answer.found);
  const MapKeyframe& near = *parts.map.FindKeyframe(answer.keyframe_id);
  const SE3 T_kf_c = ring.walk.T_w_c.at(static_cast<size_t>(near.session_keyframe_id)).Inverse() * T_w_c;
  EXPECT_LT((T_kf_c.Inverse() * (near.T_w_kf.Inverse() * answer.T_w_c)).translation().norm(), 0.05);
}

// Tied, as by a false loop, the map says that they are two places.
TEST(SeparateParts, WhereTheMapTiesThemBothContradictEachOther) {
  const Ring ring;
  TwoParts parts(ring);
  LoopEdge tie;
  tie.old_keyframe_id = 0;
  tie.keyframe_id = kFirstId;
  tie.covariance = 1e-4 * Matrix6d::Identity();
  parts.map.Add(tie);
  parts.closer.Follow(parts.map);
  EXPECT_FALSE(parts.closer.Relocalise(parts.map, ring.world.Observe(ring.walk.T_w_c[3], 0.4, 77)).found);
}

}  // namespace
}  // namespace plslam::test
