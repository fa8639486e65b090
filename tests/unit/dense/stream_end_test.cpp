// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/stream_end.h"

#include <gtest/gtest.h>

namespace plslam::dense {
namespace {

/// A stream whose last keyframe is number 4.
class StreamEndTest : public testing::Test {
 protected:
  void Commit(int64_t number) {
    MapUpdate update;
    update.newest.number = number;
    update.committed = true;
    map_.Add(update);
  }
  void Tick(int n) {
    for (int i = 0; i < n; ++i) end_.OnTick();
  }
  void EndStream() {
    end_.OnKeyframe({.session = {}, .number = 4});
    end_.OnStream(true);
    end_.OnTracker(true);
  }
  bool IsOver() const { return end_.IsOver(map_); }

  StreamEnd end_;
  NewestKeyframes map_;
};

TEST_F(StreamEndTest, ComesWithTheLastKeyframeInTheMap) {
  EndStream();
  Commit(3);
  Tick(10);
  EXPECT_FALSE(IsOver()) << "keyframe 4 is not committed";
  Commit(4);
  EXPECT_TRUE(IsOver());
  end_.OnTracker(false);
  EXPECT_FALSE(IsOver()) << "the tracker may make another keyframe";
}

TEST_F(StreamEndTest, MessagesDelayIt) {
  EndStream();
  Commit(4);
  Tick(StreamEnd::kQuietTicks);
  EXPECT_FALSE(IsOver());
  end_.OnMessage();
  Tick(StreamEnd::kQuietTicks);
  EXPECT_FALSE(IsOver());
  Tick(1);
  EXPECT_TRUE(IsOver());
}

TEST_F(StreamEndTest, MapThatStopsIsNotAwaitedForEver) {
  EndStream();
  Tick(StreamEnd::kQuietTicksForTheMap);
  EXPECT_FALSE(IsOver());
  Tick(1);
  EXPECT_TRUE(IsOver());
}

TEST_F(StreamEndTest, DoesNotComeBeforeTheStreamEnds) {
  EndStream();
  Commit(4);
  end_.OnStream(false);
  Tick(2 * StreamEnd::kQuietTicksForTheMap);
  EXPECT_FALSE(IsOver());
}

}  // namespace
}  // namespace plslam::dense
