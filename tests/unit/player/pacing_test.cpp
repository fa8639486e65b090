// SPDX-License-Identifier: BSD-3-Clause
#include "player/pacing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace plslam::player {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;
using testing::ThrowsMessage;

std::vector<std::pair<int, int64_t>> All(PlayOrder order) {
  std::vector<std::pair<int, int64_t>> items;
  while (const auto item = order.Next()) items.emplace_back(item->index, item->t_ns);
  EXPECT_EQ(order.size(), static_cast<int64_t>(items.size()));
  return items;
}

const std::vector<int64_t> kTimes = {100, 110, 130, 160, 200};

TEST(PlayOrder, WholeDataset) {
  EXPECT_THAT(All({kTimes, {}, 10.0}),
              ElementsAre(Pair(0, 100), Pair(1, 110), Pair(2, 130), Pair(3, 160), Pair(4, 200)));
}

TEST(PlayOrder, StartStopStride) {
  PlayerOptions options;
  options.start = 1;
  options.stop = 4;
  options.stride = 2;
  EXPECT_THAT(All({kTimes, options, 10.0}), ElementsAre(Pair(1, 110), Pair(3, 160)));
}

TEST(PlayOrder, SkipToGoesOnAsIfAllBeforeHadBeenPlayed) {
  PlayerOptions options;
  options.loop = 3;
  options.bounce = true;
  const auto all = All({kTimes, options, 10.0});
  for (size_t n = 0; n <= all.size(); ++n) {
    PlayOrder order(kTimes, options, 10.0);
    EXPECT_EQ(order.SkipTo(n == 0 ? 99 : all[n - 1].second), static_cast<int64_t>(n));
    for (size_t i = n; i < all.size(); ++i) {
      const auto item = order.Next();
      ASSERT_TRUE(item.has_value()) << i;
      EXPECT_EQ(std::pair(item->index, item->t_ns), all[i]);
    }
    EXPECT_FALSE(order.Next().has_value());
  }
}

TEST(ResumePoint, IsReadAsItIsWritten) {
  const ResumePoint point{12, 1403636579763555584};
  EXPECT_EQ(ParseResumePoint(ToText(point)), point);
  EXPECT_EQ(ParseResumePoint("0@-5"), (ResumePoint{0, -5}));
  for (const char* text : {"", "7", "7@", "@7", "-1@7", "7@8x", "x@8", "7 @8"}) {
    EXPECT_THAT([&] { ParseResumePoint(text); }, ThrowsMessage<std::runtime_error>(HasSubstr("is not ID@T_NS")))
        << text;
  }
}

TEST(PlayOrder, LoopContinuesAtTheMeanDistance) {
  PlayerOptions options;
  options.start = 2;
  options.loop = 2;
  EXPECT_THAT(All({kTimes, options, 10.0}),
              ElementsAre(Pair(2, 130), Pair(3, 160), Pair(4, 200), Pair(2, 235), Pair(3, 265), Pair(4, 305)));
}

TEST(PlayOrder, TwoFramesInALoopAreNoWayBack) {
  PlayerOptions options;
  options.stop = 2;
  options.loop = 2;
  EXPECT_THAT(All({kTimes, options, 10.0}), ElementsAre(Pair(0, 100), Pair(1, 110), Pair(0, 120), Pair(1, 130)));
}

TEST(PlayOrder, BounceGoesForthAndBackWithTheSameDistances) {
  PlayerOptions options;
  options.start = 2;
  options.loop = 2;
  options.bounce = true;
  EXPECT_THAT(All({kTimes, options, 10.0}),
              ElementsAre(Pair(2, 130), Pair(3, 160), Pair(4, 200), Pair(3, 240), Pair(2, 270), Pair(3, 300),
                          Pair(4, 340), Pair(3, 380), Pair(2, 410)));
}

TEST(PlayOrder, OneFrameRepeatsAtTheRate) {
  PlayerOptions options;
  options.stop = 1;
  options.loop = 3;
  for (const bool bounce : {false, true}) {
    options.bounce = bounce;
    EXPECT_THAT(All({kTimes, options, 10.0}), ElementsAre(Pair(0, 100), Pair(0, 100'000'100), Pair(0, 200'000'100)));
  }
}

TEST(PlayOrder, NothingLeftIsAnError) {
  PlayerOptions options;
  options.start = 5;
  EXPECT_THAT(
      [&] { PlayOrder(kTimes, options, 10.0); },
      ThrowsMessage<std::runtime_error>(HasSubstr("start 5, stop -1 and stride 1 leave none of the 5 frames")));
}

TEST(ParsePace, KnownAndUnknown) {
  EXPECT_TRUE(ParsePace("lockstep").lockstep);
  EXPECT_FALSE(ParsePace("realtime").lockstep);
  EXPECT_EQ(ParsePace("realtimex2").speed, 2.0);
  EXPECT_EQ(ParsePace("realtimex0.5").speed, 0.5);
  for (const char* bad :
       {"", "realtimex", "realtimex0", "realtimexnan", "realtimex2x", "realtimex-1", "realtime2", "fast"}) {
    EXPECT_THAT([&] { ParsePace(bad); }, ThrowsMessage<std::runtime_error>(HasSubstr("none of lockstep"))) << bad;
  }
}

TEST(RealtimeClock, FramesAreDueAtTheirDistanceAndLateBeyondHalfAPeriod) {
  RealtimeClock clock(2.0, 100);
  EXPECT_EQ(clock.Due_ns(1000, 7), 7);
  EXPECT_EQ(clock.Due_ns(1100, 9), 57);
  EXPECT_FALSE(clock.IsLate(57, 82));
  EXPECT_TRUE(clock.IsLate(57, 83));
}

}  // namespace
}  // namespace plslam::player
