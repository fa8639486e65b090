// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <string>

#include "loop_process/loop_service.h"
#include "tests/unit/loop/ring_world.h"

namespace plslam::test {
namespace {

constexpr SessionId kOtherRobot = 8;

/// Walks a ring until a loop is published; then all is live, and the map may take its time.
class PublishedLoop : public testing::Test {
 protected:
  void SetUp() override {
    while (loop_.kind != LoopClosure::Kind::kLoop && next_ + 3 < ring_.size()) {
      const auto output = Show(next_++);
      if (!output.closures.empty()) loop_ = output.closures.back();
    }
    ASSERT_EQ(loop_.kind, LoopClosure::Kind::kLoop);
  }

  /// The map has one more keyframe of the robot.
  loop::LoopService::Output Show(int i) {
    const Keyframe& keyframe = ring_.walk.keyframes[static_cast<size_t>(i)];
    service_.OnKeyframe(keyframe);
    EXPECT_TRUE(MapOne(keyframe, mapper_));
    return Publish(keyframe.name, false);
  }
  /// The map, as far as it has changed, with this as its newest keyframe.
  loop::LoopService::Output Publish(const KeyframeName& newest, bool committed, const LoopAnswer& answer = {}) {
    MapUpdate update = mapper_.TakeUpdate();
    update.source = 1;
    update.newest = newest;
    update.committed = committed;
    update.answer = answer;
    return service_.OnUpdate(update);
  }
  loop::LoopService::Output TakeOver() {
    std::string reason;
    EXPECT_TRUE(mapper_.Correct(loop_, &reason)) << reason;
    return Publish(loop_.keyframe, false, Answer(true));
  }
  LoopAnswer Answer(bool accepted) const { return {loop_.keyframe, loop_.map_version, accepted}; }

  Ring ring_;
  int next_ = 0;
  double now_ms_ = 0.0;
  mapping::Mapper mapper_{FeatureWorld::Camera(), mapping::MappingOptions()};
  loop::LoopService service_{loop::LoopCloser(FeatureWorld::Camera(), PlacesOf(ring_.world), {}),
                             [this] { return now_ms_; }};
  LoopClosure loop_;
};

TEST_F(PublishedLoop, WholeMapIsAdjustedWhenItArrives) {
  const auto output = TakeOver();
  ASSERT_TRUE(output.adjustment.has_value());
  EXPECT_EQ(output.adjustment->keyframe, loop_.keyframe);
  const auto committed = Publish(loop_.keyframe, true);
  EXPECT_FALSE(committed.adjustment.has_value()) << "once";
  EXPECT_FALSE(committed.ends_adjustment) << "of a live stream any adjustment is welcome";
}

// Another robot's keyframe had no loop, and so is committed.
TEST_F(PublishedLoop, OtherRobotsKeyframeIsCommittedFirst) {
  EXPECT_TRUE(Publish({kOtherRobot, 3}, true).closures.empty());
  EXPECT_TRUE(Show(next_).closures.empty()) << "nothing is checked on a map that is about to bend";
  const auto output = TakeOver();
  EXPECT_TRUE(output.adjustment.has_value());
  EXPECT_EQ(output.closures.size(), 1U);
}

TEST_F(PublishedLoop, RefusedLoopIsNotAdjusted) {
  EXPECT_FALSE(Publish(loop_.keyframe, true, Answer(false)).adjustment.has_value());
}

TEST_F(PublishedLoop, AdjustmentIncludesNewerKeyframes) {
  Show(next_);
  Show(next_ + 1);
  const KeyframeId newest = mapper_.map().keyframes().rbegin()->first;
  const auto output = TakeOver();
  ASSERT_TRUE(output.adjustment.has_value());
  EXPECT_EQ(output.adjustment->keyframes.back().keyframe_id, newest);
}

TEST_F(PublishedLoop, RefusalReleasesWaitingKeyframes) {
  EXPECT_TRUE(Show(next_).closures.empty());
  const int64_t newest = ring_.walk.keyframes[static_cast<size_t>(next_)].name.number;
  EXPECT_EQ(Publish({loop_.keyframe.session, newest}, true, Answer(false)).closures.size(), 1U);
}

TEST_F(PublishedLoop, RefusalInAnUpdateOfAnotherRobot) {
  EXPECT_TRUE(Show(next_).closures.empty());
  Publish({kOtherRobot, 3}, false);
  EXPECT_EQ(Publish({kOtherRobot, 3}, true, Answer(false)).closures.size(), 1U);
}

TEST_F(PublishedLoop, NotAwaitedAfterTheMapWasReplaced) {
  EXPECT_TRUE(Show(next_).closures.empty());
  const StereoCamera camera = FeatureWorld::Camera();
  mapping::MapperState empty;
  empty.stored.version = mapper_.version() + 1;
  empty.map_id.n_replaced = 1;
  mapper_ = mapping::Mapper(camera, mapping::MappingOptions(), std::move(empty));
  MapUpdate reset = mapper_.Whole();
  reset.source = 1;
  EXPECT_TRUE(service_.OnUpdate(reset).closures.empty()) << "nothing is left to check";
  Keyframe first = ring_.walk.keyframes.front();
  first.name.session = kOtherRobot;
  service_.OnKeyframe(first);
  EXPECT_TRUE(MapOne(first, mapper_));
  const auto output = Publish({kOtherRobot, first.name.number}, false);
  ASSERT_EQ(output.closures.size(), 1U);
  EXPECT_EQ(output.closures[0].keyframe.session, kOtherRobot);
}

TEST_F(PublishedLoop, AwaitedUntilTheMapAnswers) {
  EXPECT_TRUE(Show(next_).closures.empty());
  Publish({kOtherRobot, 3}, true);
  now_ms_ += 1e6;
  EXPECT_TRUE(service_.OnTick().closures.empty());
  LoopAnswer to_another = Answer(false);
  ++to_another.keyframe.number;
  EXPECT_TRUE(Publish({kOtherRobot, 4}, true, to_another).closures.empty());
  EXPECT_FALSE(Publish({kOtherRobot, 5}, true, Answer(false)).closures.empty());
}

}  // namespace
}  // namespace plslam::test
