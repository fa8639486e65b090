// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/node/work_queue.h"

#include <gtest/gtest.h>

#include "core/run/process_names.h"

namespace plslam::mapping {
namespace {

using Kind = WorkQueue::Work::Kind;

constexpr SessionId kSession = 7;

Keyframe KeyframeOf(int64_t id, bool lockstep) {
  Keyframe keyframe;
  keyframe.name.session = kSession;
  keyframe.name.number = id;
  keyframe.lockstep = lockstep;
  return keyframe;
}

LoopClosure ClosureOf(int64_t number, LoopClosure::Kind kind = LoopClosure::Kind::kNone, bool more = false) {
  LoopClosure closure;
  closure.kind = kind;
  closure.keyframe.session = kSession;
  closure.keyframe.number = number;
  closure.more = more;
  return closure;
}

class WorkQueueTest : public testing::Test {
 protected:
  /// Does the next work, which must be of this kind.
  WorkQueue::Work Take(Kind kind) {
    const auto work = queue_.Take(now_s_);
    EXPECT_TRUE(work);
    if (!work) return {};
    EXPECT_EQ(work->kind, kind);
    for (const auto& arrived : work->keyframes) queue_.Inserted(arrived.keyframe, 1, now_s_);
    return *work;
  }
  void ExpectNothing() { EXPECT_FALSE(queue_.Take(now_s_)); }

  double now_s_ = 100.0;
  WorkQueue queue_{true, 5.0};
};

TEST_F(WorkQueueTest, LockstepKeyframeWaitsForThePreviousAnswer) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  queue_.Add(KeyframeOf(1, true), 0.0);
  EXPECT_EQ(Take(Kind::kInsert).keyframes.size(), 1U);
  ExpectNothing();
  queue_.Add(ClosureOf(0));
  EXPECT_TRUE(Take(Kind::kCorrect).commits);
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.name.number, 1);
  ExpectNothing();
}

TEST_F(WorkQueueTest, LockstepLoopWaitsForItsAdjustment) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  queue_.Add(KeyframeOf(1, true), 0.0);
  Take(Kind::kInsert);
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kLoop, true));
  EXPECT_FALSE(Take(Kind::kCorrect).commits);
  ExpectNothing();
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kAdjustment));
  EXPECT_TRUE(Take(Kind::kCorrect).commits);
  Take(Kind::kInsert);
}

// No adjustment follows a loop that the map has refused.
TEST_F(WorkQueueTest, RefusedLoopDoesNotBlock) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  queue_.Add(KeyframeOf(1, true), 0.0);
  Take(Kind::kInsert);
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kLoop, true));
  EXPECT_FALSE(Take(Kind::kCorrect).commits);
  EXPECT_TRUE(queue_.Refused()) << "the commit is to be published";
  EXPECT_FALSE(queue_.Refused());
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.name.number, 1);
  ExpectNothing();
}

TEST_F(WorkQueueTest, ClosuresOfMissingKeyframesAreBounded) {
  queue_.Add(KeyframeOf(0, false), 0.0);
  Take(Kind::kInsert);
  LoopClosure large = ClosureOf(0, LoopClosure::Kind::kLoop);
  queue_.Add(large);
  large.points.resize(WorkQueue::kMostParts / 4);
  for (int64_t id = 1; id < 20; ++id) {
    large.keyframe.number = id;
    queue_.Add(large);
    EXPECT_LE(queue_.n_waiting(), 4U);
  }
  EXPECT_EQ(Take(Kind::kCorrect).closure.keyframe.number, 0) << "that of a keyframe that has come is not dropped";
  queue_.Add(KeyframeOf(19, false), 0.0);
  now_s_ += KeyframeQueue::kPatience_ms;
  Take(Kind::kInsert);
  EXPECT_EQ(Take(Kind::kCorrect).closure.keyframe.number, 17) << "the latest are kept";
}

TEST_F(WorkQueueTest, LockstepContinuesWithoutALoopProcess) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  queue_.Add(KeyframeOf(1, true), 0.0);
  queue_.Add(KeyframeOf(2, true), 0.0);
  Take(Kind::kInsert);
  EXPECT_FALSE(queue_.GiveUp(now_s_ + 4.0));
  ExpectNothing();
  EXPECT_TRUE(queue_.GiveUp(now_s_ + 6.0));
  Take(Kind::kCommit);
  Take(Kind::kInsert);
  Take(Kind::kCommit);
  Take(Kind::kInsert);
  queue_.OnSignOfLife(now_s_ + 7.0);
  Take(Kind::kCommit);
  queue_.Add(KeyframeOf(3, true), 0.0);
  Take(Kind::kInsert);
  ExpectNothing();
}

TEST_F(WorkQueueTest, DisabledLoopsAreNotAwaited) {
  queue_ = WorkQueue(false, 5.0);
  queue_.Add(KeyframeOf(0, true), 0.0);
  queue_.Add(ClosureOf(0));
  Take(Kind::kInsert);
  Take(Kind::kCommit);
  ExpectNothing();
}

// loop_process, which runs for relocalisation, awaits an answer to its loop before it checks the next keyframe.
TEST_F(WorkQueueTest, DisabledLoopsAreRefused) {
  for (const bool lockstep : {true, false}) {
    queue_ = WorkQueue(false, 5.0);
    queue_.Add(KeyframeOf(0, lockstep), 0.0);
    queue_.Add(ClosureOf(0, LoopClosure::Kind::kLoop));
    Take(Kind::kInsert);
    const WorkQueue::Work work = Take(Kind::kAnswer);
    EXPECT_EQ(work.closure.keyframe.number, 0);
    EXPECT_FALSE(work.accepted);
    Take(Kind::kCommit);
    queue_.Add(ClosureOf(0, LoopClosure::Kind::kAdjustment));
    ExpectNothing();
  }
}

TEST_F(WorkQueueTest, LiveKeyframesAreInsertedTogetherAndNeverWait) {
  for (int64_t id = 0; id < 3; ++id) queue_.Add(KeyframeOf(id, false), 0.0);
  EXPECT_EQ(Take(Kind::kInsert).keyframes.size(), 3U);
  queue_.Add(KeyframeOf(3, false), 0.0);
  EXPECT_EQ(Take(Kind::kInsert).keyframes.size(), 1U);
  queue_.Add(ClosureOf(1, LoopClosure::Kind::kLoop));
  EXPECT_FALSE(Take(Kind::kCorrect).commits) << "late, but right";
  queue_.Add(ClosureOf(2));
  ExpectNothing();
  queue_.Add(ClosureOf(3));
  EXPECT_TRUE(Take(Kind::kCorrect).commits);
}

TEST_F(WorkQueueTest, EachBatchIsOfOneSession) {
  const auto of = [](SessionId session, int64_t id, int64_t t_ns) {
    Keyframe keyframe = KeyframeOf(id, false);
    keyframe.source = SourceId(session.value);
    keyframe.name.session = session;
    keyframe.t_ns = t_ns;
    return keyframe;
  };
  queue_.Add(of(kSession, 0, 10), 0.0);
  queue_.Add(of(kSession, 1, 20), 0.0);
  queue_.Add(of(SessionId(kSession.value + 1), 0, 30), 0.0);
  queue_.Add(of(kSession, 2, 40), 0.0);
  EXPECT_EQ(Take(Kind::kInsert).keyframes.size(), 2U);
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.name.session, SessionId(kSession.value + 1));
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.name.number, 2);
}

TEST_F(WorkQueueTest, HistoriesAfterARestartGiveTheSameOrder) {
  queue_.Add(ClosureOf(0));
  queue_.Add(ClosureOf(1, LoopClosure::Kind::kLoop, true));
  queue_.Add(ClosureOf(1, LoopClosure::Kind::kAdjustment));
  queue_.Add(ClosureOf(2));
  ExpectNothing();
  for (int64_t id = 0; id < 3; ++id) queue_.Add(KeyframeOf(id, true), 0.0);
  Take(Kind::kInsert);
  EXPECT_EQ(Take(Kind::kCorrect).closure.keyframe.number, 0);
  Take(Kind::kInsert);
  EXPECT_EQ(Take(Kind::kCorrect).closure.kind, LoopClosure::Kind::kLoop);
  EXPECT_EQ(Take(Kind::kCorrect).closure.kind, LoopClosure::Kind::kAdjustment);
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.name.number, 2);
  EXPECT_EQ(Take(Kind::kCorrect).closure.keyframe.number, 2);
  ExpectNothing();
}

TEST_F(WorkQueueTest, SecondClosureOfACommittedKeyframe) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  Take(Kind::kInsert);
  queue_.Add(ClosureOf(0));
  Take(Kind::kCorrect);
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kLoop));
  EXPECT_FALSE(Take(Kind::kAnswer).accepted);
  ExpectNothing();
}

TEST_F(WorkQueueTest, TheMapIsSavedWhenItsNewestKeyframeIsCommitted) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  Take(Kind::kInsert);
  queue_.Add(bus::Order{command_verb::kSave, "a.plmap"});
  ExpectNothing();
  queue_.AskForWhole();
  Take(Kind::kPublishWhole);
  queue_.Add(ClosureOf(0));
  Take(Kind::kCorrect);
  EXPECT_EQ(Take(Kind::kOrder).order.argument, "a.plmap");
  ExpectNothing();
}

TEST_F(WorkQueueTest, ResetFollowsAnEarlierOrder) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  Take(Kind::kInsert);
  queue_.Add(bus::Order{command_verb::kReset, ""});
  EXPECT_EQ(Take(Kind::kOrder).order.verb, command_verb::kReset);
  queue_.Add(bus::Order{command_verb::kSave, "a.plmap"});
  queue_.Add(bus::Order{command_verb::kLocalise, "on"});
  queue_.Add(bus::Order{command_verb::kReset, ""});
  ExpectNothing();
  queue_.Add(ClosureOf(0));
  Take(Kind::kCorrect);
  EXPECT_EQ(Take(Kind::kOrder).order.verb, command_verb::kSave);
  EXPECT_EQ(Take(Kind::kOrder).order.verb, command_verb::kLocalise);
  EXPECT_EQ(Take(Kind::kOrder).order.verb, command_verb::kReset);
}

TEST_F(WorkQueueTest, NewMapDiscardsTheQueueOfTheOldMap) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  Take(Kind::kInsert);
  queue_.Add(KeyframeOf(1, true), 0.0);
  queue_.Add(ClosureOf(1));
  queue_.Add(bus::Order{command_verb::kLocalise, "on"});
  queue_.Reset({}, {}, {});
  EXPECT_EQ(Take(Kind::kOrder).order.argument, "on") << "what was ordered behind it stays";
  ExpectNothing();
  EXPECT_EQ(queue_.n_waiting(), 0U);
  queue_.Add(KeyframeOf(0, true), 0.0);
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.name.number, 0);
}

TEST_F(WorkQueueTest, RepeatedMessagesAreIgnored) {
  queue_.Add(KeyframeOf(0, true), 0.0);
  queue_.Add(KeyframeOf(0, true), 0.0);
  EXPECT_EQ(queue_.n_keyframes(), 1U);
  Take(Kind::kInsert);
  queue_.Add(KeyframeOf(0, true), 0.0);
  EXPECT_EQ(queue_.n_keyframes(), 0U);
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kLoop, true));
  EXPECT_FALSE(Take(Kind::kCorrect).commits);
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kLoop, true));
  ExpectNothing();
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kAdjustment));
  EXPECT_TRUE(Take(Kind::kCorrect).commits) << "another one about the same keyframe";
}

// The mapper exited between a loop and the following adjustment: loop_process checks the keyframe again, on the map of
// the restarted mapper, which has the loop from the history.
TEST_F(WorkQueueTest, LockstepLoopFoundOnTwoMapsIsAppliedOnce) {
  const auto found_on = [](SourceId source, LoopClosure::Kind kind, bool more) {
    LoopClosure closure = ClosureOf(0, kind, more);
    closure.map_version = {{}, source, 1};
    return closure;
  };
  queue_.Add(KeyframeOf(0, true), 0.0);
  Take(Kind::kInsert);
  queue_.Add(found_on(1, LoopClosure::Kind::kLoop, true));
  EXPECT_FALSE(Take(Kind::kCorrect).commits);
  queue_.Add(found_on(2, LoopClosure::Kind::kLoop, true));
  EXPECT_TRUE(Take(Kind::kAnswer).accepted) << "its loop_process adjusts the map";
  ExpectNothing();
  queue_.Add(found_on(2, LoopClosure::Kind::kAdjustment, false));
  EXPECT_TRUE(Take(Kind::kCorrect).commits);
  queue_.Add(found_on(1, LoopClosure::Kind::kAdjustment, false));
  ExpectNothing();
}

// A mapping_process that was killed after an order, and restarted without its state, receives the keyframes of both maps.
TEST_F(WorkQueueTest, KeyframesOfTheNextMapBeginIt) {
  const auto of_map = [](int64_t number, int64_t n_replaced) {
    Keyframe keyframe = KeyframeOf(number, false);
    keyframe.map_id.n_replaced = n_replaced;
    return keyframe;
  };
  queue_.Add(KeyframeOf(9, false), 0.0);
  queue_.AddOfNextMap(of_map(0, 1), 0.0);
  queue_.AddOfNextMap(of_map(0, 2), 0.0);
  queue_.AddOfNextMap(of_map(1, 1), 0.0);
  queue_.AddOfNextMap(of_map(1, 2), 0.0);
  EXPECT_EQ(Take(Kind::kBeginMap).map_id.n_replaced, 2) << "the newest one";
  queue_.AddOfNextMap(of_map(2, 2), 0.0);
  queue_.Reset({{}, 2}, {}, {});
  const auto work = Take(Kind::kInsert);
  ASSERT_EQ(work.keyframes.size(), 3U) << "those of the replaced maps are dropped";
  for (int64_t i = 0; i < 3; ++i) EXPECT_EQ(work.keyframes[static_cast<size_t>(i)].keyframe.name.number, i);
  ExpectNothing();
}

TEST_F(WorkQueueTest, KeyframesOfALaterMapAreHeldBeyondReset) {
  Keyframe keyframe = KeyframeOf(0, false);
  keyframe.map_id.n_replaced = 3;
  queue_.AddOfNextMap(keyframe, 0.0);
  queue_.Reset({{}, 2}, {}, {});
  EXPECT_EQ(Take(Kind::kBeginMap).map_id.n_replaced, 3);
}

TEST_F(WorkQueueTest, MissingKeyframesAreCountedAfterATimeout) {
  queue_.Add(KeyframeOf(0, true), 1000.0 * now_s_);
  Take(Kind::kInsert);
  queue_.Add(ClosureOf(0));
  Take(Kind::kCorrect);
  queue_.Add(KeyframeOf(3, true), 1000.0 * now_s_);
  ExpectNothing();
  now_s_ += 10.0;
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].missing, 2);
}

TEST_F(WorkQueueTest, RepeatedLiveLoopIsAppliedOnce) {
  queue_.Add(KeyframeOf(0, false), 0.0);
  Take(Kind::kInsert);
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kLoop));
  queue_.Add(ClosureOf(0, LoopClosure::Kind::kLoop));
  Take(Kind::kCorrect);
  ExpectNothing();
}

// Each keyframe has a closure, for as long as the process runs.
TEST_F(WorkQueueTest, TakenClosuresAreForgotten) {
  constexpr auto kMany = static_cast<int64_t>(WorkQueue::kMostTaken) + 100;
  for (int64_t id = 0; id < kMany; ++id) {
    queue_.Add(KeyframeOf(id, false), 0.0);
    Take(Kind::kInsert);
    queue_.Add(ClosureOf(id));
    Take(Kind::kCorrect);
  }
  EXPECT_EQ(queue_.n_recognised(), 0U);
  for (int64_t id = 0; id < kMany; ++id) {
    queue_.Add(ClosureOf(id, LoopClosure::Kind::kLoop));
    Take(Kind::kCorrect);
  }
  EXPECT_EQ(queue_.n_recognised(), WorkQueue::kMostTaken);
  queue_.Add(ClosureOf(kMany - 1));
  queue_.Add(ClosureOf(kMany - 1, LoopClosure::Kind::kLoop));
  ExpectNothing();
}

TEST_F(WorkQueueTest, OldestKeyframeOfSeveralPublishersFirst) {
  const auto of = [](SourceId source, SessionId session, int64_t id, int64_t t_ns) {
    Keyframe keyframe = KeyframeOf(id, true);
    keyframe.source = source;
    keyframe.name.session = session;
    keyframe.t_ns = t_ns;
    return keyframe;
  };
  // The live tracker is answered before the publisher of old messages.
  queue_.Add(of(1, 200, 0, 50), 0.0);
  queue_.Add(of(1, 200, 1, 60), 0.0);
  queue_.Add(of(2, 100, 0, 10), 0.0);
  queue_.Add(of(2, 100, 1, 40), 0.0);
  EXPECT_EQ(queue_.n_keyframes(), 4U);
  for (const int64_t t_ns : {10, 40, 50, 60}) {
    const auto work = Take(Kind::kInsert);
    ASSERT_EQ(work.keyframes.size(), 1U);
    const Keyframe& keyframe = work.keyframes[0].keyframe;
    EXPECT_EQ(keyframe.t_ns, t_ns);
    LoopClosure said = ClosureOf(keyframe.name.number);
    said.keyframe = keyframe.name;
    queue_.Add(said);
    Take(Kind::kCorrect);
  }
  // For one publisher, the session that it published first comes first, even if time goes back.
  queue_.Add(of(1, 300, 0, 90), 0.0);
  queue_.Add(of(1, 301, 0, 5), 0.0);
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.t_ns, 90);
}

TEST_F(WorkQueueTest, OnlyNewKeyframesAfterARestart) {
  queue_.Restore({{kSession, 4}, {SessionId(kSession.value - 1), 9}}, kSession);
  for (int64_t id = 0; id < 6; ++id) queue_.Add(KeyframeOf(id, true), 0.0);
  for (int id = 0; id < 5; ++id) queue_.Add(ClosureOf(id, LoopClosure::Kind::kLoop));
  EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.name.number, 5);
  ExpectNothing();
  queue_.Add(ClosureOf(5));
  EXPECT_TRUE(Take(Kind::kCorrect).commits);
  ExpectNothing();
}

TEST_F(WorkQueueTest, SaveAfterARestartWaitsForEarlierKeyframes) {
  queue_.Restore({{kSession, 4}}, kSession);
  queue_.Add(bus::Order{command_verb::kSave, "a.plmap"});
  for (int id = 5; id < 7; ++id) {
    queue_.Add(KeyframeOf(id, true), 0.0);
    queue_.Add(ClosureOf(id));
  }
  for (int64_t id = 5; id < 7; ++id) {
    EXPECT_EQ(Take(Kind::kInsert).keyframes[0].keyframe.name.number, id);
    EXPECT_EQ(Take(Kind::kCorrect).closure.keyframe.number, id);
  }
  Take(Kind::kOrder);
  ExpectNothing();
}

TEST(WorkQueueState, WrittenPeriodicallyAndBeforeANewSession) {
  WorkQueue queue(true, 5.0, 2);
  const auto insert = [&](const Keyframe& keyframe) {
    queue.Add(keyframe, 0.0);
    const auto work = queue.Take(0.0);
    ASSERT_TRUE(work && work->kind == Kind::kInsert);
    queue.Inserted(keyframe, 1, 0.0);
  };
  insert(KeyframeOf(0, true));
  queue.Add(ClosureOf(0));
  EXPECT_EQ(queue.Take(0.0)->kind, Kind::kCorrect);
  EXPECT_FALSE(queue.Take(0.0)) << "one keyframe is not worth it";
  insert(KeyframeOf(1, true));
  EXPECT_FALSE(queue.Take(0.0)) << "not all has been said";
  queue.Add(ClosureOf(1));
  EXPECT_EQ(queue.Take(0.0)->kind, Kind::kCorrect);
  EXPECT_EQ(queue.Take(0.0)->kind, Kind::kKeepState);
  EXPECT_FALSE(queue.Take(0.0)) << "once";
  insert(KeyframeOf(2, true));
  queue.Add(ClosureOf(2));
  EXPECT_EQ(queue.Take(0.0)->kind, Kind::kCorrect);
  Keyframe other = KeyframeOf(0, true);
  other.name.session = SessionId(kSession.value + 1);
  queue.Add(other, 0.0);
  EXPECT_EQ(queue.Take(0.0)->kind, Kind::kKeepState) << "before the new session";
  EXPECT_EQ(queue.Take(0.0)->kind, Kind::kInsert);
}

TEST(WorkQueueState, WrittenBeforeAnotherPublisherContinues) {
  WorkQueue queue(false, 5.0, 100);
  const auto of = [](SourceId source, int64_t id) {
    Keyframe keyframe = KeyframeOf(id, true);
    keyframe.source = source;
    return keyframe;
  };
  const auto insert = [&](const Keyframe& keyframe) {
    const auto work = queue.Take(0.0);
    ASSERT_TRUE(work && work->kind == Kind::kInsert);
    ASSERT_EQ(work->keyframes.front().keyframe.name.number, keyframe.name.number);
    queue.Inserted(keyframe, 1, 0.0);
    EXPECT_EQ(queue.Take(0.0)->kind, Kind::kCommit);
  };
  queue.Add(of(1, 0), 0.0);
  insert(of(1, 0));
  EXPECT_FALSE(queue.Add(of(2, 0), 0.0));
  EXPECT_FALSE(queue.Take(0.0)) << "nothing new";
  queue.Add(of(2, 1), 0.0);
  EXPECT_EQ(queue.Take(0.0)->kind, Kind::kKeepState);
  insert(of(2, 1));
  queue.Add(of(2, 2), 0.0);
  insert(of(2, 2));
}

TEST(WorkQueueState, EachKeyframeOfABatchCounts) {
  WorkQueue queue(false, 5.0, 2);
  queue.Add(KeyframeOf(0, false), 0.0);
  queue.Add(KeyframeOf(1, false), 0.0);
  const auto work = queue.Take(0.0);
  ASSERT_TRUE(work && work->kind == Kind::kInsert);
  ASSERT_EQ(work->keyframes.size(), 2U);
  queue.Inserted(work->keyframes.back().keyframe, 2, 0.0);
  queue.Add(ClosureOf(1));
  bool kept = false;
  while (const auto next = queue.Take(0.0)) kept = kept || next->kind == Kind::kKeepState;
  EXPECT_TRUE(kept);
}

}  // namespace
}  // namespace plslam::mapping
