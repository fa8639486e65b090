// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/loop_service.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/feature_world.h"
#include "tests/unit/places/random_places.h"

namespace plslam::loop {
namespace {

using test::FeatureWorld;

constexpr SessionId kSession = 7;

Keyframe KeyframeOf(int64_t id, bool lockstep = true) {
  Keyframe keyframe;
  keyframe.name.session = kSession;
  keyframe.name.number = id;
  keyframe.frame_id = FrameId(10 * id);
  keyframe.lockstep = lockstep;
  keyframe.previous_keyframe_id = id - 1;
  return keyframe;
}

/// A map whose keyframes have no common features: no loop can be found, only the order is tested.
class Service : public testing::Test {
 protected:
  /// The version of the map with keyframes up to this one of the session.
  MapUpdate Update(int64_t number, bool committed) {
    while (next_id_ <= number) {
      MapKeyframe keyframe;
      keyframe.id = KeyframeId(next_id_);
      keyframe.name.session = kSession;
      keyframe.name.number = next_id_;
      keyframe.previous_id = keyframe.parent_id = KeyframeId(next_id_ - 1);
      map_.Put(keyframe);
      ++next_id_;
    }
    MapUpdate update = ChangedPart(map_, map_.TakeChanges());
    Sign(update, number, committed);
    update.Follow(version_++);
    return update;
  }
  MapUpdate Whole(int64_t number, bool committed, SourceId source) {
    MapUpdate update = WholeMap(map_);
    Sign(update, number, committed);
    update.version = version_;
    update.source = source_ = source;
    return update;
  }
  void Sign(MapUpdate& update, int64_t number, bool committed) const {
    update.source = source_;
    update.newest.session = kSession;
    update.newest.number = number;
    update.committed = committed;
  }
  /// Adds keyframes 0 to this one of another session to the map, unless they are in it.
  void PutOther(int64_t number) {
    for (; next_other_ <= number; ++next_other_) {
      MapKeyframe keyframe;
      keyframe.id = KeyframeId(kOtherIds + next_other_);
      keyframe.name.session = SessionId(kSession.value + 1);
      keyframe.name.number = next_other_;
      if (next_other_ > 0) keyframe.previous_id = keyframe.parent_id = KeyframeId(keyframe.id.value - 1);
      map_.Put(keyframe);
    }
  }
  static Keyframe OfOther(int64_t id) {
    Keyframe keyframe = KeyframeOf(id);
    keyframe.name.session = SessionId(kSession.value + 1);
    return keyframe;
  }
  static std::vector<int64_t> Checked(const LoopService::Output& output) {
    std::vector<int64_t> ids;
    for (const LoopClosure& closure : output.closures) {
      EXPECT_EQ(closure.keyframe.session, kSession);
      EXPECT_EQ(closure.kind, LoopClosure::Kind::kNone);
      ids.push_back(closure.keyframe.number);
    }
    return ids;
  }

  using Ids = std::vector<int64_t>;
  Map map_;
  static constexpr int64_t kOtherIds = 1000;
  int64_t next_id_ = 0;
  int64_t next_other_ = 0;
  int64_t version_ = 0;
  SourceId source_ = 1;
  double now_ms_ = 0.0;
  LoopService service_{LoopCloser(FeatureWorld::Camera(),
                                  PlaceRecogniser(test::SmallVocabulary(FeatureType::kPoints),
                                                  test::SmallVocabulary(FeatureType::kLines), {}),
                                  LoopOptions()),
                       [this] { return now_ms_; }};
};

TEST_F(Service, MapAndFeaturesArriveInEitherOrder) {
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(0))), Ids{});
  EXPECT_EQ(Checked(service_.OnUpdate(Update(0, false))), Ids{0});
  EXPECT_EQ(Checked(service_.OnUpdate(Update(0, true))), Ids{});
  EXPECT_EQ(Checked(service_.OnUpdate(Update(1, false))), Ids{});
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(1))), Ids{1});
  EXPECT_EQ(Checked(service_.OnUpdate(Update(1, true))), Ids{});
}

TEST_F(Service, RepublishedKeyframesAreNotCheckedAgain) {
  service_.OnKeyframe(KeyframeOf(0));
  service_.OnUpdate(Update(0, false));
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(0))), Ids{});
  // In any order: a message that a publisher had lost may be republished by another later.
  service_.OnKeyframe(KeyframeOf(2));
  service_.OnUpdate(Update(0, true));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(2, false))), Ids{});
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(1))), (Ids{1, 2}));
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(2))), Ids{});
}

TEST_F(Service, WaitsForMissingFeaturesUntilATimeout) {
  service_.OnKeyframe(KeyframeOf(0, false));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(0, false))), Ids{0});
  service_.OnKeyframe(KeyframeOf(2, false));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(2, false))), Ids{});
  now_ms_ += LoopService::kPatience_ms - 1.0;
  EXPECT_EQ(Checked(service_.OnTick()), Ids{});
  now_ms_ += 1.0;
  EXPECT_EQ(Checked(service_.OnTick()), (Ids{1, 2}));
}

// A cable that is disconnected for seconds does not change the result.
TEST_F(Service, LockstepWaitsForFeaturesOfALiveTracker) {
  constexpr SourceId kTracker = 77;
  Keyframe first = KeyframeOf(0);
  first.source = kTracker;
  service_.OnKeyframe(first);
  EXPECT_EQ(Checked(service_.OnUpdate(Update(0, false))), Ids{0});
  EXPECT_EQ(Checked(service_.OnUpdate(Update(1, false))), Ids{});
  now_ms_ += LoopService::kLockstepPatience_ms - 1.0;
  EXPECT_EQ(Checked(service_.OnTick()), Ids{});
  service_.OnSignOfLife(kTracker);
  now_ms_ += LoopService::kLockstepPatience_ms - 1.0;
  service_.OnSignOfLife(78);
  EXPECT_EQ(Checked(service_.OnTick()), Ids{});
  now_ms_ += 1.0;
  EXPECT_EQ(Checked(service_.OnTick()), Ids{1}) << "it is dead";
}

// loop_process was restarted, and several publishers send the keyframes: the live tracker first.
TEST_F(Service, WholeMapIsCheckedWithAllItsFeatures) {
  Update(5, false);
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(5))), Ids{});
  EXPECT_EQ(Checked(service_.OnUpdate(Whole(5, false, 2))), Ids{});
  Keyframe request = KeyframeOf(6);
  request.previous_keyframe_id = -1;
  EXPECT_TRUE(service_.OnRequest(request).answers.empty());
  for (int64_t id = 0; id < 4; ++id) EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(id))), Ids{}) << id;
  const auto output = service_.OnKeyframe(KeyframeOf(4));
  EXPECT_EQ(Checked(output), Ids{5});
  EXPECT_EQ(output.answers.size(), 1U);
}

TEST_F(Service, WholeMapWithMissingFeaturesTimesOut) {
  Update(5, false);
  for (const int64_t id : {1, 3, 5}) service_.OnKeyframe(KeyframeOf(id));
  service_.OnUpdate(Whole(5, false, 2));
  now_ms_ += LoopService::kPatience_ms - 1.0;
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(4))), Ids{}) << "more is coming";
  now_ms_ += LoopService::kPatience_ms - 1.0;
  EXPECT_EQ(Checked(service_.OnTick()), Ids{});
  service_.OnUpdate(Update(6, false));
  now_ms_ += 1.0;
  EXPECT_EQ(Checked(service_.OnTick()), Ids{5}) << "updates that come meanwhile do not prolong it";
}

// mapping_process was restarted, and its map has a keyframe that had been removed: its features are published again,
// too.
TEST_F(Service, KeyframeRestoredByAnOlderMapIsUsedAgain) {
  for (int id = 0; id < 3; ++id) {
    service_.OnKeyframe(KeyframeOf(id));
    service_.OnUpdate(Update(id, false));
  }
  const Map older = map_;
  map_.RemoveKeyframe(1);
  service_.OnKeyframe(KeyframeOf(3));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(3, false))), Ids{3});
  service_.OnKeyframe(KeyframeOf(4));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(4, false))), Ids{4}) << "now it is gone for good";
  map_ = older;
  next_id_ = 3;
  service_.OnUpdate(Whole(2, true, 2));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(3, false))), Ids{});
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(1))), Ids{3});
}

// mapping_process applies no loops, so each keyframe is committed before it can be checked.
TEST_F(Service, FeaturesAreDroppedWithoutChecks) {
  for (int id = 0; id < 3; ++id) {
    service_.OnKeyframe(KeyframeOf(id));
    EXPECT_EQ(Checked(service_.OnUpdate(Update(id, true))), Ids{});
  }
  const Map older = map_;
  map_.RemoveKeyframe(1);
  service_.OnKeyframe(KeyframeOf(3));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(3, true))), Ids{});
  map_ = older;
  service_.OnUpdate(Whole(2, true, 2));
  now_ms_ += MissingFeatures::kRequestAfter_ms;
  EXPECT_EQ(service_.OnTick().missing_keyframes, std::vector<KeyframeId>{1});
}

// The previous loop_process closed a loop and exited during global bundle adjustment.
TEST_F(Service, UnfinishedAdjustmentIsDoneAfterARestart) {
  Update(3, false);
  LoopEdge edge;
  edge.old_keyframe_id = 0;
  edge.keyframe_id = 3;
  edge.covariance.setIdentity();
  map_.Add(edge);
  for (int64_t id = 0; id < 3; ++id) service_.OnKeyframe(KeyframeOf(id));
  EXPECT_FALSE(service_.OnUpdate(Whole(3, false, 2)).adjustment);
  const auto output = service_.OnKeyframe(KeyframeOf(3));
  ASSERT_TRUE(output.adjustment) << "when all features are there";
  EXPECT_EQ(Checked(output), Ids{}) << "that is not checked again";
  EXPECT_EQ(output.adjustment->keyframe.session, kSession);
  EXPECT_EQ(output.adjustment->keyframe.number, 3);
  EXPECT_EQ(output.adjustment->map_version->numbering, 2);
  EXPECT_EQ(output.adjustment->keyframes.size(), 4U);
  EXPECT_FALSE(service_.OnUpdate(Update(3, true)).adjustment);
  service_.OnKeyframe(KeyframeOf(4));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(4, false))), Ids{4});
}

// The same if the updates are repeated, one by one, before the features.
TEST_F(Service, UnfinishedAdjustmentFromRepeatedUpdates) {
  service_.OnUpdate(Update(0, false));
  service_.OnUpdate(Update(0, true));
  service_.OnUpdate(Update(1, false));
  LoopEdge edge;
  edge.old_keyframe_id = 0;
  edge.keyframe_id = 1;
  edge.covariance.setIdentity();
  map_.Add(edge);
  service_.OnUpdate(Update(1, false));
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(1))), Ids{});
  const auto output = service_.OnKeyframe(KeyframeOf(0));
  EXPECT_EQ(Checked(output), Ids{});
  ASSERT_TRUE(output.adjustment);
  EXPECT_EQ(output.adjustment->keyframe.number, 1);
  EXPECT_EQ(output.adjustment->map_version->number, 4);
  EXPECT_TRUE(service_.OnUpdate(Update(1, true)).ends_adjustment) << "the other had come to its end";
  EXPECT_FALSE(service_.OnUpdate(Update(2, false)).ends_adjustment);
}

// A keyframe would be checked on a map that is newer than the one into which it was inserted.
TEST_F(Service, CommittedKeyframesInRepeatedUpdates) {
  for (int id = 0; id < 3; ++id) {
    EXPECT_EQ(Checked(service_.OnUpdate(Update(id, false))), Ids{});
    if (id < 2) service_.OnUpdate(Update(id, true));
  }
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(0))), Ids{});
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(1))), Ids{});
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(2))), Ids{2});
}

TEST_F(Service, CommittedMapNeedsNoAdjustment) {
  Update(3, false);
  LoopEdge edge;
  edge.old_keyframe_id = 0;
  edge.keyframe_id = 3;
  map_.Add(edge);
  for (int64_t id = 0; id <= 3; ++id) service_.OnKeyframe(KeyframeOf(id));
  EXPECT_FALSE(service_.OnUpdate(Whole(3, true, 2)).adjustment);
}

TEST_F(Service, KeyframesOfOneUpdateAreAllChecked) {
  for (int64_t id = 0; id < 4; ++id) service_.OnKeyframe(KeyframeOf(id, false));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(3, false))), (Ids{3}));
  for (int64_t id = 4; id < 7; ++id) service_.OnKeyframe(KeyframeOf(id, false));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(6, false))), (Ids{4, 5, 6}));
}

TEST_F(Service, StartedMidRunChecksTheNewestKeyframe) {
  Update(20, false);
  for (int64_t id = 0; id <= 20; ++id) service_.OnKeyframe(KeyframeOf(id));
  EXPECT_EQ(Checked(service_.OnUpdate(Whole(20, false, 5))), Ids{20});
  EXPECT_EQ(Checked(service_.OnUpdate(Update(21, false))), Ids{});
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(21))), Ids{21});
}

// loop_process was restarted: keyframes of other sessions in the map were checked by the previous one.
TEST_F(Service, RestartWithSeveralSessionsChecksTheNewest) {
  Update(20, false);
  PutOther(10);
  for (int64_t id = 0; id <= 22; ++id) service_.OnKeyframe(KeyframeOf(id));
  for (int64_t id = 0; id <= 11; ++id) service_.OnKeyframe(OfOther(id));
  EXPECT_EQ(Checked(service_.OnUpdate(Whole(20, false, 5))), Ids{20});
  PutOther(11);
  MapUpdate of_other = Update(20, false);
  of_other.newest.session = SessionId(kSession.value + 1);
  of_other.newest.number = 11;
  const auto output = service_.OnUpdate(of_other);
  ASSERT_EQ(output.closures.size(), 1U);
  EXPECT_EQ(output.closures[0].keyframe.number, 11);
}

// Versions were missed meanwhile: all keyframes of a known session are checked.
TEST_F(Service, RequestedWholeMapChecksAllNewKeyframes) {
  for (int64_t id = 0; id <= 5; ++id) service_.OnKeyframe(KeyframeOf(id));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(0, false))), Ids{0});
  Update(3, false);
  EXPECT_EQ(Checked(service_.OnUpdate(Whole(3, false, 1))), (Ids{1, 2, 3}));
}

// A lost robot sends no keyframes; the other one commits the map for both.
TEST_F(Service, RequestOfALostRobotAfterARestart) {
  Update(3, false);
  PutOther(10);
  for (int64_t id = 0; id <= 3; ++id) service_.OnKeyframe(KeyframeOf(id));
  for (int64_t id = 0; id <= 10; ++id) service_.OnKeyframe(OfOther(id));
  service_.OnUpdate(Whole(3, false, 5));
  Keyframe request = OfOther(11);
  request.previous_keyframe_id = 10;
  EXPECT_TRUE(service_.OnRequest(request).answers.empty());
  EXPECT_EQ(service_.OnUpdate(Update(3, true)).answers.size(), 1U);
}

TEST_F(Service, ForgedKeyframeIdIsHarmless) {
  service_.OnKeyframe(KeyframeOf(0));
  service_.OnUpdate(Update(0, false));
  MapUpdate forged = Update(0, false);
  forged.newest.number = std::numeric_limits<int64_t>::max();
  service_.OnUpdate(forged);
  now_ms_ += LoopService::kPatience_ms;
  EXPECT_LE(service_.OnTick().closures.size(), 1U);
}

TEST_F(Service, CommittedKeyframeIsNotCheckedAgain) {
  Update(20, false);
  for (int64_t id = 0; id <= 20; ++id) service_.OnKeyframe(KeyframeOf(id));
  EXPECT_EQ(Checked(service_.OnUpdate(Whole(20, true, 5))), Ids{});
}

TEST_F(Service, LateFeaturesDoNotDelayOtherRobots) {
  service_.OnKeyframe(KeyframeOf(0));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(0, false))), Ids{0});
  PutOther(0);
  MapUpdate of_other = Update(0, false);
  of_other.newest.session = SessionId(kSession.value + 1);
  service_.OnUpdate(of_other);
  EXPECT_EQ(Checked(service_.OnUpdate(Update(1, false))), Ids{});
  EXPECT_EQ(Checked(service_.OnKeyframe(KeyframeOf(1))), Ids{1});
  EXPECT_EQ(service_.OnKeyframe(OfOther(0)).closures.size(), 1U);
}

TEST_F(Service, RebuiltMapIsCheckedAgain) {
  for (int id = 0; id < 3; ++id) {
    service_.OnKeyframe(KeyframeOf(id));
    service_.OnUpdate(Update(id, false));
    service_.OnUpdate(Update(id, true));
  }
  // mapping_process was restarted: its map is rebuilt keyframe by keyframe.
  map_ = Map();
  next_id_ = version_ = 0;
  source_ = 2;
  EXPECT_EQ(Checked(service_.OnUpdate(Update(0, false))), Ids{0});
  service_.OnUpdate(Update(0, true));
  EXPECT_EQ(Checked(service_.OnUpdate(Update(1, false))), Ids{1});
}

TEST_F(Service, LockstepRequestWaitsForTheCommittedMap) {
  Keyframe request = KeyframeOf(1);
  request.frame_id = 17;
  request.previous_keyframe_id = 0;
  EXPECT_TRUE(service_.OnRequest(request).answers.empty());
  service_.OnKeyframe(KeyframeOf(0));
  EXPECT_TRUE(service_.OnUpdate(Update(0, false)).answers.empty());
  const auto output = service_.OnUpdate(Update(0, true));
  ASSERT_EQ(output.answers.size(), 1U);
  EXPECT_EQ(output.answers[0].frame_id, 17);
  EXPECT_EQ(output.answers[0].session, kSession);
  EXPECT_EQ(output.answers[0].map_version->number, 2);
  EXPECT_FALSE(output.answers[0].found);
  EXPECT_TRUE(service_.OnUpdate(Update(1, false)).answers.empty()) << "it is answered once";
}

TEST_F(Service, NewerRequestReplacesAWaitingOne) {
  Keyframe request = KeyframeOf(0, false);
  EXPECT_EQ(service_.OnRequest(request).answers.size(), 1U) << "not found, where there is no map";
  request.lockstep = true;
  service_.OnRequest(request);
  request.frame_id = 99;
  service_.OnRequest(request);
  service_.OnKeyframe(KeyframeOf(0));
  const auto output = service_.OnUpdate(Update(0, true));
  ASSERT_EQ(output.answers.size(), 1U);
  EXPECT_EQ(output.answers[0].frame_id, 99);
}

}  // namespace
}  // namespace plslam::loop
