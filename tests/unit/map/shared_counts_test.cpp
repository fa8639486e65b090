// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace plslam {
namespace {

using Counts = std::vector<SharedCounts::Count>;

Counts All(const SharedCounts& counts) { return {counts.begin(), counts.end()}; }

TEST(SharedCounts, AscendByKeyframeWhateverTheOrder) {
  SharedCounts counts;
  for (const int64_t id : {7, 3, 9, 3, 7, 3}) counts.Add(id, 1);
  EXPECT_EQ(All(counts), (Counts{{3, 3}, {7, 2}, {9, 1}}));
  EXPECT_EQ(counts.Of(3), 3);
  EXPECT_EQ(counts.Of(4), 0);
  EXPECT_EQ(counts.Of(10), 0);
}

TEST(SharedCounts, KeyframesThatNoLongerShareAnythingGo) {
  SharedCounts counts;
  counts.Add(5, 1);
  counts.Add(6, 2);
  counts.Add(5, -1);
  counts.Add(6, -1);
  EXPECT_EQ(All(counts), (Counts{{6, 1}}));
}

}  // namespace
}  // namespace plslam
