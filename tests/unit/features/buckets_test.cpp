// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/matching/buckets.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

namespace plslam {
namespace {

std::vector<int> Listed(std::span<const int> items) { return {items.begin(), items.end()}; }

TEST(Buckets, HoldNothingUntilFilled) {
  EXPECT_EQ(Buckets<int>().size(), 0U);
  Buckets<int> none({}, 3, [](int) { return 0; });
  ASSERT_EQ(none.size(), 3U);
  for (size_t b = 0; b < none.size(); ++b) EXPECT_TRUE(none[b].empty());
  EXPECT_TRUE(none.Range(0, 3).empty());
}

TEST(Buckets, KeepTheOrderWithinEachAndLieSideBySide) {
  Buckets<int> tens({31, 12, 5, 39, 11, 30, 7}, 4, [](int item) { return item / 10; });
  EXPECT_EQ(Listed(tens[0]), (std::vector<int>{5, 7}));
  EXPECT_EQ(Listed(tens[1]), (std::vector<int>{12, 11}));
  EXPECT_TRUE(tens[2].empty());
  EXPECT_EQ(Listed(tens[3]), (std::vector<int>{31, 39, 30}));
  EXPECT_EQ(Listed(tens.Range(1, 4)), (std::vector<int>{12, 11, 31, 39, 30}));
  EXPECT_TRUE(tens.Range(2, 2).empty());
}

TEST(Buckets, MayBeReorderedInside) {
  Buckets<int> pair({4, 3, 9, 8}, 2, [](int item) { return item / 5; });
  std::swap(pair[1].front(), pair[1].back());
  EXPECT_EQ(Listed(pair.Range(0, 2)), (std::vector<int>{4, 3, 8, 9}));
}

TEST(Buckets, ListIndicesOfOtherElements) {
  std::mt19937 random(1);
  std::vector<size_t> things(1000);
  for (size_t& thing : things) thing = random() % 37;
  Buckets<int> places = IndicesByBucket(things.size(), 37, [&](int i) { return things[static_cast<size_t>(i)]; });
  size_t total = 0;
  for (size_t b = 0; b < 37; ++b) {
    int before = -1;
    for (const int i : places[b]) {
      EXPECT_EQ(things[static_cast<size_t>(i)], b);
      EXPECT_GT(i, before);
      before = i;
    }
    total += places[b].size();
  }
  EXPECT_EQ(total, things.size());
}

}  // namespace
}  // namespace plslam
