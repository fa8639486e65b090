// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/map_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plslam {
namespace {

using testing::ElementsAre;

/// Keyframes 0 to 2 of session 1, and 3 and 4 of session 2, which began unconnected.
Map TwoSessions() {
  Map map;
  for (int i = 0; i < 5; ++i) {
    MapKeyframe keyframe;
    keyframe.id = i;
    keyframe.name.session = i < 3 ? 1 : 2;
    keyframe.previous_id = keyframe.parent_id = i == 0 || i == 3 ? -1 : i - 1;
    map.Put(keyframe);
    MapPoint point;
    point.id = i;
    point.observations = {{i, 0}};
    map.Put(point);
  }
  return map;
}

bool All(const MapKeyframe&) { return true; }

TEST(MapParts, ConnectedMapHasOne) {
  Map map = TwoSessions();
  LoopEdge loop;
  loop.old_keyframe_id = 0;
  loop.keyframe_id = 4;
  map.Add(loop);
  EXPECT_THAT(PartsOf(map, All), ElementsAre(ElementsAre(0, 1, 2, 3, 4)));
}

TEST(MapParts, LargestFirstUnlessOfTheRun) {
  const Map map = TwoSessions();
  EXPECT_THAT(PartsOf(map, All), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(3, 4)));
  const auto of_the_second = [](const MapKeyframe& keyframe) { return keyframe.name.session == 2; };
  EXPECT_THAT(PartsOf(map, of_the_second), ElementsAre(ElementsAre(3, 4), ElementsAre(0, 1, 2)));
  EXPECT_THAT(PartsOf(Map(), All), ElementsAre());
}

TEST(MapParts, PartHasItsOwnLandmarks) {
  const Map part = PartOf(TwoSessions(), {3, 4});
  EXPECT_EQ(part.keyframes().size(), 2U);
  EXPECT_EQ(part.points().size(), 2U);
  EXPECT_NE(part.FindPoint(3), nullptr);
  EXPECT_EQ(part.FindPoint(0), nullptr);
}

}  // namespace
}  // namespace plslam
