// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/landmark_types.h"

#include <gtest/gtest.h>

#include "tests/unit/localisation/handmade_map.h"

namespace plslam {
namespace {

using Ids = std::vector<LandmarkId>;
using Keyframes = std::vector<KeyframeId>;

class SeenByKeyframes : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 3; ++i) world_.AddKeyframe(SE3());
    // Ids and the order of features differ, and a feature of keyframe 1 shows no landmark.
    const Eigen::Vector3d p_w(0.1, 0.2, 4.0);
    world_.SeePoint(1, p_w, {});
    world_.PutPoint(7, p_w, {}, {world_.SeePoint(0, p_w, {}), world_.SeePoint(1, p_w, {})});
    world_.PutPoint(2, p_w, {}, {world_.SeePoint(0, p_w, {}), world_.SeePoint(2, p_w, {})});
    world_.PutPoint(5, p_w, {}, {world_.SeePoint(1, p_w, {})});
    const Segment3 segment_w{p_w, {0.5, 0.3, 4.0}};
    world_.PutLine(3, segment_w, {}, {world_.SeeLine(1, segment_w, {}), world_.SeeLine(2, segment_w, {})});
  }

  test::HandmadeMap world_;
};

TEST_F(SeenByKeyframes, EachOnceAscendingForAnyQueryOrder) {
  for (const Keyframes& keyframes : {Keyframes{0, 1}, Keyframes{1, 0}, Keyframes{1, 0, 1}}) {
    EXPECT_EQ(SeenBy<PointType>(keyframes, world_.map), (Ids{2, 5, 7})) << testing::PrintToString(keyframes);
    EXPECT_EQ(SeenBy<LineType>(keyframes, world_.map), Ids{3}) << testing::PrintToString(keyframes);
  }
}

TEST_F(SeenByKeyframes, OneKeyframe) {
  EXPECT_EQ(SeenBy<PointType>({2}, world_.map), Ids{2});
  EXPECT_EQ(SeenBy<LineType>({0}, world_.map), Ids{});
}

TEST_F(SeenByKeyframes, NoKeyframe) {
  EXPECT_EQ(SeenBy<PointType>({}, world_.map), Ids{});
  EXPECT_EQ(SeenBy<LineType>({}, world_.map), Ids{});
}

}  // namespace
}  // namespace plslam
