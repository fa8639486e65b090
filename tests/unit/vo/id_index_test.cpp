// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmark_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace plslam::vo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

TEST(IdIndex, HasTheValuesOfAnIdInTheOrderInWhichTheyCame) {
  const IdIndex<std::string> index({{7, "a"}, {3, "b"}, {7, "c"}, {-1, "d"}, {7, "b"}});
  EXPECT_THAT(index.Find(7), ElementsAre(Pair(7, "a"), Pair(7, "c"), Pair(7, "b")));
  EXPECT_THAT(index.Find(3), ElementsAre(Pair(3, "b")));
  EXPECT_THAT(index.Find(-1), ElementsAre(Pair(-1, "d")));
}

TEST(IdIndex, HasNothingForOtherIds) {
  EXPECT_THAT(IdIndex<int>({}).Find(0), IsEmpty());
  EXPECT_THAT(IdIndex<int>({{1, 1}, {3, 3}}).Find(2), IsEmpty());
}

}  // namespace
}  // namespace plslam::vo
