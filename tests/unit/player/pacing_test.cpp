// SPDX-License-Identifier: BSD-3-Clause
#include "player/pacing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>
#include <vector>

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

PlayOrder Order(const PlayerOptions& options) {
  return {std::ssize(kTimes), [](int index) { return kTimes.at(static_cast<size_t>(index)); }, options, 10.0};
}

TEST(PlayOrder, WholeDataset) {
  EXPECT_THAT(All(Order({})), ElementsAre(Pair(0, 100), Pair(1, 110), Pair(2, 130), Pair(3, 160), Pair(4, 200)));
}

TEST(PlayOrder, StartStopStride) {
  PlayerOptions options;
  options.start = 1;
  options.stop = 4;
  options.stride = 2;
  EXPECT_THAT(All(Order(options)), ElementsAre(Pair(1, 110), Pair(3, 160)));
}

TEST(PlayOrder, SkipToContinuesTheSamePlayOrder) {
  PlayerOptions options;
  options.loop = 3;
  options.bounce = true;
  const auto all = All(Order(options));
  for (size_t n = 0; n <= all.size(); ++n) {
    PlayOrder order = Order(options);
    EXPECT_EQ(order.SkipTo(n == 0 ? 99 : all[n - 1].second), static_cast<int64_t>(n));
    for (size_t i = n; i < all.size(); ++i) {
      const auto item = order.Next();
      ASSERT_TRUE(item.has_value()) << i;
      EXPECT_EQ(std::pair(item->index, item->t_ns), all[i]);
    }
    EXPECT_FALSE(order.Next().has_value());
  }
}

TEST(PlayOrder, LoopContinuesAtTheMeanDistance) {
  PlayerOptions options;
  options.start = 2;
  options.loop = 2;
  EXPECT_THAT(All(Order(options)),
              ElementsAre(Pair(2, 130), Pair(3, 160), Pair(4, 200), Pair(2, 235), Pair(3, 265), Pair(4, 305)));
}

TEST(PlayOrder, TwoFramesInALoop) {
  PlayerOptions options;
  options.stop = 2;
  options.loop = 2;
  EXPECT_THAT(All(Order(options)), ElementsAre(Pair(0, 100), Pair(1, 110), Pair(0, 120), Pair(1, 130)));
}

TEST(PlayOrder, BounceGoesForthAndBackWithTheSameDistances) {
  PlayerOptions options;
  options.start = 2;
  options.loop = 2;
  options.bounce = true;
  EXPECT_THAT(All(Order(options)), ElementsAre(Pair(2, 130), Pair(3, 160), Pair(4, 200), Pair(3, 240), Pair(2, 270),
                                               Pair(3, 300), Pair(4, 340), Pair(3, 380), Pair(2, 410)));
}

TEST(PlayOrder, OneFrameRepeatsAtTheRate) {
  PlayerOptions options;
  options.stop = 1;
  options.loop = 3;
  for (const bool bounce : {false, true}) {
    options.bounce = bounce;
    EXPECT_THAT(All(Order(options)), ElementsAre(Pair(0, 100), Pair(0, 100'000'100), Pair(0, 200'000'100)));
  }
}

TEST(PlayOrder, NothingLeftIsAnError) {
  PlayerOptions options;
  options.start = 5;
  EXPECT_THAT([&] { Order(options); }, ThrowsMessage<std::runtime_error>(
                                           HasSubstr("start 5, stop -1 and stride 1 leave none of the 5 frames")));
}

}  // namespace
}  // namespace plslam::player
