// SPDX-License-Identifier: BSD-3-Clause
#include "core/ids/map_version.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

constexpr MapId kBegun{7, 0};

TEST(MapId, OrderReplacesTheMap) {
  const MapId next = kBegun.Next();
  EXPECT_FALSE(next.Matches(kBegun));
  EXPECT_TRUE(next.Supersedes(kBegun));
  EXPECT_FALSE(kBegun.Supersedes(next));
  EXPECT_FALSE(kBegun.Supersedes(kBegun));
}

TEST(MapId, MapsOfTwoOriginsAreUnrelated) {
  const MapId other{8, 1};
  EXPECT_FALSE(other.Matches(kBegun));
  EXPECT_FALSE(other.Supersedes(kBegun));
}

TEST(MapId, UnknownOriginMayBeAny) {
  EXPECT_TRUE(MapId().Matches(kBegun));
  EXPECT_TRUE(kBegun.Matches(MapId()));
  EXPECT_FALSE(MapId().Matches(kBegun.Next())) << "a session without a map belongs to no map that replaced another";
  EXPECT_TRUE(kBegun.Next().Supersedes(MapId()));
}

}  // namespace
}  // namespace plslam
