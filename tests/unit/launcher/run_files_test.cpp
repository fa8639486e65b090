// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace plslam::launcher {
namespace {

TEST(DefaultOut, HasTheNameOfTheLocation) {
  EXPECT_EQ(DefaultOut("/data/kitti/03"), "out/data_kitti_03");
  EXPECT_EQ(DefaultOut("data/./kitti/x/../03"), "out/data_kitti_03");
  EXPECT_EQ(DefaultOut("synthetic:room?rate=10&seed=2"), "out/synthetic_room_rate_10_seed_2");
}

TEST(DefaultOut, LongLocationKeepsItsEnd) {
  const std::string hard = "/data/" + std::string(90, 'x') + "/Hard/";
  const std::string name = DefaultOut(hard + "P010").filename();
  EXPECT_THAT(name, testing::MatchesRegex("x+_Hard_P010_[0-9a-f]{8}"));
  EXPECT_EQ(name.size(), 80U + 9U);
  EXPECT_EQ(DefaultOut(hard + "P010"), DefaultOut(hard + "/P010")) << "the same at each run";
}

TEST(DefaultOut, DifferentLocationsGiveDifferentFolders) {
  const std::string x(100, 'x');
  std::set<std::string> names;
  const std::vector<std::string> locations{
      "/" + x + "/P010", "/" + x + "/P011", "/a/" + x + "/P010", "/数据/一", "/数据/二", "seq", "../seq", "数"};
  for (const std::string& location : locations) names.insert(DefaultOut(location));
  EXPECT_EQ(names.size(), locations.size()) << testing::PrintToString(names);
}

}  // namespace
}  // namespace plslam::launcher
