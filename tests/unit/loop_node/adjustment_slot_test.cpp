// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/node/adjustment_slot.h"

#include <gtest/gtest.h>

#include <thread>

namespace plslam::loop {
namespace {

using Outcome = AdjustmentSlot::Outcome;

GlobalBundleProblem ProblemOf(int64_t keyframe) {
  GlobalBundleProblem problem;
  problem.keyframe.number = keyframe;
  return problem;
}

TEST(AdjustmentSlot, NewestProblemIsTaken) {
  AdjustmentSlot slot;
  slot.Put(ProblemOf(3));
  slot.Put(ProblemOf(5));
  const auto job = slot.Take();
  ASSERT_TRUE(job);
  EXPECT_EQ(job->problem.keyframe.number, 5);
  EXPECT_FALSE(job->forgets_progress);
  EXPECT_FALSE(slot.interrupts());
  EXPECT_EQ(slot.OutcomeOf(*job), Outcome::kCurrent);
}

TEST(AdjustmentSlot, NewProblemOutdatesTheRunningOne) {
  AdjustmentSlot slot;
  slot.Put(ProblemOf(3));
  const auto first = slot.Take();
  slot.Put(ProblemOf(5));
  EXPECT_TRUE(slot.interrupts());
  EXPECT_EQ(slot.OutcomeOf(*first), Outcome::kOutdated);
  const auto second = slot.Take();
  EXPECT_EQ(slot.OutcomeOf(*second), Outcome::kCurrent);
}

TEST(AdjustmentSlot, DroppedOneStaysOutdated) {
  AdjustmentSlot slot;
  slot.Put(ProblemOf(3));
  const auto job = slot.Take();
  slot.Drop(false);
  EXPECT_TRUE(slot.interrupts());
  EXPECT_EQ(slot.OutcomeOf(*job), Outcome::kOutdated);
  slot.Put(ProblemOf(5));
  EXPECT_FALSE(slot.Take()->forgets_progress);
  EXPECT_EQ(slot.OutcomeOf(*job), Outcome::kOutdated) << "also when no problem waits";
}

TEST(AdjustmentSlot, ProgressIsForgottenOnce) {
  AdjustmentSlot slot;
  slot.Put(ProblemOf(3));
  slot.Drop(true);
  slot.Put(ProblemOf(5));
  EXPECT_TRUE(slot.Take()->forgets_progress);
  slot.Put(ProblemOf(7));
  EXPECT_FALSE(slot.Take()->forgets_progress);
}

TEST(AdjustmentSlot, StopEndsTheWaitAndTheJob) {
  AdjustmentSlot slot;
  slot.Put(ProblemOf(3));
  const auto job = slot.Take();
  std::thread stopper([&slot] { slot.Stop(); });
  EXPECT_FALSE(slot.Take());
  stopper.join();
  EXPECT_TRUE(slot.interrupts());
  EXPECT_EQ(slot.OutcomeOf(*job), Outcome::kStopped);
}

}  // namespace
}  // namespace plslam::loop
