// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "loop_process/loop_closer.h"
#include "tests/unit/loop/ring_world.h"

namespace plslam::test {
namespace {

using Kind = LoopClosure::Kind;

// In a single session the map numbers keyframes as the session does.
SE3 TrueRelation(const LoopEdge& edge, const std::vector<SE3>& T_w_c) {
  return T_w_c.at(static_cast<size_t>(edge.old_keyframe_id.value)).Inverse() *
         T_w_c.at(static_cast<size_t>(edge.keyframe_id.value));
}

// Returns the relative pose of two keyframes after the closure.
SE3 Corrected(const LoopClosure& loop, KeyframeId a, KeyframeId b) {
  SE3 T_w_a;
  SE3 T_w_b;
  for (const CorrectedPose& pose : loop.poses) {
    if (pose.keyframe_id == a) T_w_a = pose.T_w_kf;
    if (pose.keyframe_id == b) T_w_b = pose.T_w_kf;
  }
  return T_w_a.Inverse() * T_w_b;
}

std::string Describe(const loop::LoopSearch& search) {
  std::string text = "looked at:";
  for (const loop::LoopEvidence& e : search.evidence) {
    text += fmt::format(" {} {} inliers {} cells {} share {} back {} confirming {};", e.edge.old_keyframe_id,
                        loop::LoopVerdictName(e.verdict), e.place.inliers, e.place.cells, e.place.landmarks.Share(),
                        e.reverse_inliers, e.confirming);
  }
  return text;
}

void ExpectSame(const LoopClosure& a, const LoopClosure& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.lines, b.lines);
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(a.poses[i].keyframe_id, b.poses[i].keyframe_id);
    EXPECT_EQ(a.poses[i].T_w_kf.matrix(), b.poses[i].T_w_kf.matrix());
  }
}

TEST(LoopCloser, ReturningRingIsClosed) {
  const Ring ring;
  Closing open(PlacesOf(ring.world), {});
  for (const Keyframe& keyframe : ring.walk.keyframes) open.Show(keyframe);
  const Closing closed = CloseLoops(ring);
  ASSERT_FALSE(closed.loops.empty());
  const LoopEdge& edge = closed.loops.front().edges.front();
  const SE3 error = TrueRelation(edge, ring.walk.T_w_c).Inverse() * edge.T_old_kf;
  EXPECT_LT(error.translation().norm(), 0.02) << edge.T_old_kf.translation().transpose();
  EXPECT_LT(error.Log().tail<3>().norm(), 0.005);
  EXPECT_TRUE(closed.loops.front().more);
  EXPECT_GT(closed.loops.front().points.size(), 20U);
  EXPECT_LT(PositionError_m(closed.mapper.map(), ring.walk.T_w_c),
            PositionError_m(open.mapper.map(), ring.walk.T_w_c));
  EXPECT_EQ(WrongWith(closed.mapper.map()), "");
}

// The same loop again, in a map that was corrected by it.
TEST(LoopCloser, AgreeingLoopOfThinnedMapAsksNoMore) {
  const Ring ring;
  Closing closing(PlacesOf(ring.world), {});
  LoopClosure loop;
  int shown = 0;
  while (loop.kind == Kind::kNone && shown < ring.size()) loop = closing.Show(ring.walk.keyframes[shown++]);
  ASSERT_EQ(loop.kind, Kind::kLoop);
  EXPECT_TRUE(loop.more);
  Map map = closing.mapper.map();
  std::map<KeyframeId, SE3> poses;
  for (const CorrectedPose& pose : loop.poses) poses[pose.keyframe_id] = pose.T_w_kf;
  map.Move(poses);
  const Keyframe& last = ring.walk.keyframes[shown - 1];
  ASSERT_GT(2 * map.keyframes().rbegin()->first.value, 3 * static_cast<int64_t>(map.keyframes().size()))
      << "it was thinned";
  const LoopClosure again = closing.closer.Check(map, last.name);
  ASSERT_EQ(again.kind, Kind::kLoop);
  EXPECT_FALSE(again.more);
}

/// Gives each keyframe the vertical of a sensor that is tilted by `tilt_rad` in the second half of the walk.
void MeasureVerticals(Ring& ring, double tilt_rad) {
  for (size_t i = 0; i < ring.walk.keyframes.size(); ++i) {
    const double tilt = 2 * i < ring.walk.keyframes.size() ? 0.0 : tilt_rad;
    const Eigen::Vector3d up_c = ring.walk.T_w_c[i].R().transpose() * -Eigen::Vector3d::UnitY();
    ring.walk.keyframes[i].up = UpDirection{ExpSO3({0.0, 0.0, tilt}) * up_c, 0.2 * kRadPerDeg};
  }
}

TEST(LoopCloser, VerticalsMustAgree) {
  Ring ring;
  const size_t loops = CloseLoops(ring).loops.size();
  ASSERT_GT(loops, 0U);
  MeasureVerticals(ring, 0.0);
  EXPECT_EQ(CloseLoops(ring).loops.size(), loops);
  MeasureVerticals(ring, 8.0 * kRadPerDeg);
  Closing tilted(PlacesOf(ring.world), {});
  int n_tilted = 0;
  for (const Keyframe& keyframe : ring.walk.keyframes) {
    EXPECT_EQ(tilted.Show(keyframe).kind, Kind::kNone);
    for (const loop::LoopEvidence& evidence : tilted.closer.last_search().evidence)
      n_tilted += evidence.verdict == loop::LoopVerdict::kTilted ? 1 : 0;
  }
  EXPECT_GT(n_tilted, 0);
}

TEST(LoopCloser, ArcThatNeverReturnsHasNoLoop) {
  const Ring ring(30);
  const Closing closing = CloseLoops(ring);
  EXPECT_TRUE(closing.loops.empty());
}

TEST(LoopCloser, RestartedCloserFindsTheSameLoop) {
  const Ring ring;
  const PlaceRecogniser places = PlacesOf(ring.world);
  Closing closing(places, {});
  LoopClosure loop;
  int shown = 0;
  while (loop.kind == Kind::kNone && shown < ring.size()) loop = closing.Show(ring.walk.keyframes[shown++]);
  ASSERT_EQ(loop.kind, Kind::kLoop);
  // After a restart everything arrives at once, the map first.
  loop::LoopCloser fresh(FeatureWorld::Camera(), places, {});
  const Keyframe& last = ring.walk.keyframes[shown - 1];
  EXPECT_EQ(fresh.Check(closing.mapper.map(), last.name).kind, Kind::kNone);
  for (int i = 0; i < shown; ++i) fresh.AddKeyframe(ring.walk.keyframes[i]);
  ExpectSame(fresh.Check(closing.mapper.map(), last.name), loop);
}

TEST(LoopCloser, UnanchoredSessionIsJoined) {
  const Ring ring(26);
  Closing closing(PlacesOf(ring.world), {});
  for (const Keyframe& keyframe : ring.walk.keyframes) closing.TakeOver(closing.Show(keyframe));
  ASSERT_TRUE(closing.loops.empty());
  // Another tracker starts on the other side of the ring, which the first has not seen, with a different origin, and
  // reaches the start of the first, a little off its path.
  const std::vector<SE3> path = RingPath(4.0, 0.4, 74);
  std::vector<SE3> beside;
  for (int i = 44; i < 74; ++i) beside.push_back(path[i] * SE3(Eigen::Quaterniond::Identity(), {0.2, 0.05, 0.1}));
  WalkOptions options;
  options.with_ids = false;
  options.session = 8;
  options.seed = 5;
  Walk second = MakeWalk(ring.world, beside, options);
  const SE3 T_own_world = SE3(ExpSO3({0.0, 0.5, 0.0}), {3.0, 0.0, 1.0});
  for (Keyframe& keyframe : second.keyframes) keyframe.T_odom_kf = T_own_world * keyframe.T_odom_kf;
  LoopClosure loop;
  size_t shown = 0;
  std::string searches;
  while (loop.kind == Kind::kNone && shown < second.keyframes.size()) {
    loop = closing.Show(second.keyframes[shown++]);
    searches += Describe(closing.closer.last_search()) + "\n";
  }
  ASSERT_EQ(loop.kind, Kind::kLoop) << searches;
  const LoopEdge& edge = loop.edges.front();
  const SE3 T_old_kf = ring.walk.T_w_c.at(edge.old_keyframe_id.value).Inverse() * beside.at(shown - 1);
  EXPECT_LT((T_old_kf.Inverse() * edge.T_old_kf).translation().norm(), 0.03);
  // The older part of the map is unchanged, the newer one is moved to it.
  EXPECT_EQ(loop.poses.front().keyframe_id, 0);
  for (const CorrectedPose& pose : loop.poses) {
    const MapKeyframe& keyframe = *closing.mapper.map().FindKeyframe(pose.keyframe_id);
    if (keyframe.name.session == 8) continue;
    EXPECT_LT((keyframe.T_w_kf.Inverse() * pose.T_w_kf).translation().norm(), 1e-6) << pose.keyframe_id;
  }
  EXPECT_LT((Corrected(loop, edge.old_keyframe_id, edge.keyframe_id).Inverse() * edge.T_old_kf).translation().norm(),
            1e-3);
}

// For example a keyframe that is checked late, with others in the map already: the newer one detects the loop.
TEST(LoopCloser, OldEndOfALoopIsOlderThanTheNewEnd) {
  const Ring ring;
  Closing open(PlacesOf(ring.world), {});
  int found = 0;
  for (const Keyframe& keyframe : ring.walk.keyframes) found += open.Show(keyframe).kind == Kind::kLoop ? 1 : 0;
  ASSERT_GT(found, 0);
  const Map& map = open.mapper.map();
  for (const Keyframe& keyframe : ring.walk.keyframes) {
    const LoopClosure loop = open.closer.Check(map, keyframe.name);
    for (const LoopEdge& edge : loop.edges) EXPECT_LT(edge.old_keyframe_id, edge.keyframe_id);
  }
}

TEST(LoopCloser, EqualImagesAtTheSamePlace) {
  const Ring ring;
  Closing closing(PlacesOf(ring.world), {});
  std::vector<Keyframe> keyframes(ring.walk.keyframes.begin(), ring.walk.keyframes.begin() + 63);
  // The lap ends in the very images that it began with; odometry has drifted by then.
  for (size_t i = 0; i < 4; ++i) {
    Keyframe again = ring.walk.keyframes[i];
    const Keyframe& before = keyframes.back();
    const SE3 T_step = i == 0 ? ring.walk.T_w_c[62].Inverse() * ring.walk.T_w_c[0]
                              : ring.walk.T_w_c[i - 1].Inverse() * ring.walk.T_w_c[i];
    again.name.number = before.name.number + 1;
    again.previous_keyframe_id = before.name.number;
    again.T_odom_kf = before.T_odom_kf * T_step;
    again.T_prevkf_kf = T_step;
    again.covariance = before.covariance;
    again.t_ns = before.t_ns + 100'000'000;
    keyframes.push_back(again);
  }
  for (const Keyframe& keyframe : keyframes) closing.TakeOver(closing.Show(keyframe));
  ASSERT_FALSE(closing.loops.empty());
  // Loops of the last laps' images with themselves have no motion at all.
  const MapKeyframe& newest = closing.mapper.map().keyframes().rbegin()->second;
  const SE3 T_first_newest = closing.mapper.map().FindKeyframe(0)->T_w_kf.Inverse() * newest.T_w_kf;
  const SE3 apart = (ring.walk.T_w_c[0].Inverse() * ring.walk.T_w_c[3]).Inverse() * T_first_newest;
  EXPECT_LT(apart.translation().norm(), 0.03);
  EXPECT_EQ(WrongWith(closing.mapper.map()), "");
}

TEST(LoopCloser, EmptyAndInvalidKeyframes) {
  const Ring ring(12);
  Closing closing(PlacesOf(ring.world), {});
  for (int i = 0; i < 8; ++i) closing.Show(ring.walk.keyframes[i]);
  Keyframe empty = ring.walk.keyframes[8];
  empty.features = {};
  Keyframe one = ring.walk.keyframes[9];
  one.features.points.resize(1);
  one.features.lines.clear();
  Keyframe nonsense = ring.walk.keyframes[10];
  for (StereoPoint& point : nonsense.features.points)
    point.left.px.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (Keyframe* keyframe : {&empty, &one, &nonsense}) {
    keyframe->point_landmark_ids.assign(keyframe->features.points.size(), -1);
    keyframe->line_landmark_ids.assign(keyframe->features.lines.size(), -1);
    EXPECT_EQ(closing.Show(*keyframe).kind, Kind::kNone);
    EXPECT_FALSE(closing.closer.Relocalise(closing.mapper.map(), keyframe->features).found);
  }
  EXPECT_EQ(closing.closer.Check(closing.mapper.map(), {99, 0}).kind, Kind::kNone);
  EXPECT_EQ(closing.closer.Check(Map(), {7, 0}).kind, Kind::kNone);
}

TEST(LoopCloser, DisabledFindsNoLoop) {
  const Ring ring;
  loop::LoopOptions options;
  options.enabled = false;
  EXPECT_TRUE(CloseLoops(ring, options).loops.empty());
}

TEST(Relocaliser, FramesNearThePathAreFoundOthersAreNot) {
  const Ring ring(40);
  const Closing closing = CloseLoops(ring);
  const Map& map = closing.mapper.map();
  int found = 0;
  constexpr int kTrials = 12;
  for (int i = 0; i < kTrials; ++i) {
    const SE3 T_w_c = ring.walk.T_w_c[3 * i + 2] * SE3(ExpSO3({0.02, 0.1, -0.03}), {0.15, -0.1, 0.1});
    const Relocalisation answer = closing.closer.Relocalise(map, ring.world.Observe(T_w_c, 0.4, 77 + i));
    if (!answer.found) continue;
    ++found;
    const MapKeyframe& near = *map.FindKeyframe(answer.keyframe_id);
    const SE3 T_kf_c = ring.walk.T_w_c.at(static_cast<size_t>(near.name.number)).Inverse() * T_w_c;
    const SE3 error = T_kf_c.Inverse() * (near.T_w_kf.Inverse() * answer.T_w_c);
    EXPECT_LT(error.translation().norm(), 0.05) << "trial " << i;
    EXPECT_LT(error.Log().tail<3>().norm(), 0.02) << "trial " << i;
  }
  EXPECT_GE(found, kTrials - 1);
  const Ring elsewhere(12, 9);
  for (int i = 0; i < 12; ++i) {
    EXPECT_FALSE(closing.closer.Relocalise(map, elsewhere.walk.keyframes[i].features).found) << i;
  }
}

}  // namespace
}  // namespace plslam::test

// Maps with a part in a separate frame, because it is not connected with the rest yet.

namespace plslam::test {
namespace {

constexpr SessionId kOtherSession = 8;
// Number of keyframes of the other part of which the earlier part is a copy.
constexpr int kCopied = 12;
// First ids of the rest of the map.
constexpr int kFirstId = 1000;
constexpr int64_t kFirstLandmark = 1000000;

template <class AnId>
AnId Shifted(AnId id, int64_t by) {
  return id < 0 ? AnId() : AnId(id.value + by);
}

std::vector<Observation> ShiftedObservations(std::vector<Observation> observations, int64_t by) {
  for (Observation& observation : observations)
    observation = {Shifted(observation.keyframe_id(), by), observation.feature};
  return observations;
}

void PutKeyframes(const Map& from, int64_t n, int64_t shift, SessionId session, const SE3& T_new_old, Map& to) {
  for (const auto& [id, keyframe] : from.keyframes()) {
    if (id.value >= n) break;
    MapKeyframe put = keyframe;
    put.id = Shifted(put.id, shift);
    put.name.session = session;
    put.previous_id = Shifted(put.previous_id, shift);
    put.parent_id = Shifted(put.parent_id, shift);
    put.T_w_kf = T_new_old * keyframe.T_w_kf;
    to.Put(put);
  }
}

// Copies the landmarks that keyframes below `n` observe, with these observations.
void PutLandmarks(const Map& from, int64_t n, int64_t shift, int64_t landmark_shift, const SE3& T_new_old, Map& to) {
  const auto is_of_others = [n](const Observation& observation) { return observation.keyframe_id().value >= n; };
  for (const auto& [id, point] : from.points()) {
    MapPoint put = point;
    put.id = Shifted(put.id, landmark_shift);
    std::erase_if(put.observations, is_of_others);
    put.observations = ShiftedObservations(put.observations, shift);
    put.p_w = T_new_old * point.p_w;
    if (!put.observations.empty()) to.Put(put);
  }
  for (const auto& [id, line] : from.lines()) {
    MapLine put = line;
    put.id = Shifted(put.id, landmark_shift);
    std::erase_if(put.observations, is_of_others);
    put.observations = ShiftedObservations(put.observations, shift);
    put.segment_w = {T_new_old * line.segment_w.p, T_new_old * line.segment_w.q};
    if (!put.observations.empty()) to.Put(put);
  }
}

/// A lap of the ring, and a copy of its beginning as an earlier session, with a different origin.
struct TwoParts {
  Map map;
  loop::LoopCloser closer;
  int64_t newest = -1;  ///< as its session counts; the first keyframe whose loop is detected in the lap alone

  explicit TwoParts(const Ring& ring) : closer(FeatureWorld::Camera(), PlacesOf(ring.world), {}) {
    Closing lap(PlacesOf(ring.world), {});
    for (const Keyframe& keyframe : ring.walk.keyframes) {
      closer.AddKeyframe(keyframe);
      newest = keyframe.name.number;
      if (lap.Show(keyframe).kind == LoopClosure::Kind::kLoop) break;
    }
    for (Keyframe keyframe : std::vector(ring.walk.keyframes.begin(), ring.walk.keyframes.begin() + kCopied)) {
      keyframe.name.session = kOtherSession;
      closer.AddKeyframe(keyframe);
    }
    const Map& whole = lap.mapper.map();
    const SE3 T_own_w(ExpSO3({0.1, 0.7, 0.0}), {3.0, 1.0, -2.0});
    PutKeyframes(whole, kCopied, 0, kOtherSession, T_own_w, map);
    PutKeyframes(whole, newest + 1, kFirstId, ring.walk.keyframes.front().name.session, SE3(), map);
    PutLandmarks(whole, kCopied, 0, 0, T_own_w, map);
    PutLandmarks(whole, newest + 1, kFirstId, kFirstLandmark, SE3(), map);
  }
};

bool SeesFirstPart(const loop::LoopEvidence& evidence) { return evidence.edge.old_keyframe_id < kFirstId; }

TEST(SeparateParts, LoopDespiteCandidatesInAnotherPart) {
  const Ring ring;
  TwoParts parts(ring);
  const LoopClosure loop = parts.closer.Check(parts.map, {ring.walk.keyframes.front().name.session, parts.newest});
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
  const SE3 T_kf_c = ring.walk.T_w_c.at(static_cast<size_t>(near.name.number)).Inverse() * T_w_c;
  EXPECT_LT((T_kf_c.Inverse() * (near.T_w_kf.Inverse() * answer.T_w_c)).translation().norm(), 0.05);
}

// Connected, for example by a false loop, the two parts are at different places in the map.
TEST(SeparateParts, ConnectedPartsContradictEachOther) {
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
