// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/forgetting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <set>
#include <utility>

#include "core/io/maps/map_file.h"
#include "tests/support/long_tests.h"
#include "tests/unit/mapping/many_laps.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Keyframes along z, one after the other. Each shows the landmarks of its scene within 1.5 m, ten to a metre.
class Path {
 public:
  void Add(double z_m, int scene = 0) {
    MapKeyframe keyframe;
    keyframe.id = n_;
    keyframe.name.number = n_;
    keyframe.frame_id = FrameId(n_);
    keyframe.previous_id = keyframe.parent_id = n_ - 1;
    keyframe.T_w_kf = SE3(Eigen::Quaterniond::Identity(), {0.0, 0.0, z_m});
    if (n_ > 0) keyframe.T_prevkf_kf = map_.FindKeyframe(n_ - 1)->T_w_kf.Inverse() * keyframe.T_w_kf;
    map_.Put(keyframe);
    visits_.Add(keyframe);
    int32_t feature = 0;
    for (int place = static_cast<int>(std::ceil(10.0 * z_m - 14.9)); place < 10.0 * z_m + 15.0; ++place) {
      observations_[{scene, place}].push_back({n_, feature++});
    }
    ++n_;
  }

  std::vector<KeyframeId> Forgotten(size_t max_keyframes, const std::set<KeyframeId>& kept = {}) {
    int id = 0;
    for (const auto& [place, observations] : observations_) {
      MapPoint point;
      point.id = id++;
      point.p_w = {0.0, 0.0, 0.1 * place.second};
      point.depth_m = 1.0;
      point.observations = observations;
      map_.Put(point);
    }
    return KeyframesToForget(map_, visits_, max_keyframes,
                             [&](const MapKeyframe& keyframe) { return kept.contains(keyframe.id); });
  }

 private:
  int n_ = 0;
  Map map_;
  Visits visits_;
  std::map<std::pair<int, int>, std::vector<Observation>> observations_;
};

TEST(KeyframesToForget, NoneAsLongAsTheyFit) {
  Path path;
  for (int i = 0; i < 5; ++i) path.Add(i);
  EXPECT_THAT(path.Forgotten(5), IsEmpty());
}

/// To 16 m and back along the same way, 30 cm beside the first views. The way back begins with keyframe 17.
Path ThereAndBack(int scene_of_way_back) {
  Path path;
  for (int i = 0; i <= 16; ++i) path.Add(i);
  for (int i = 15; i >= 0; --i) path.Add(i + 0.3, scene_of_way_back);
  return path;
}

TEST(KeyframesToForget, OldestOfThoseThatShowNothingNew) {
  // From 11.3 m on the way from there to the end and back is long enough: that is keyframe 21.
  EXPECT_THAT(ThereAndBack(0).Forgotten(32), ElementsAre(21));
  EXPECT_THAT(ThereAndBack(0).Forgotten(30), ElementsAre(21, 22, 23));
  EXPECT_THAT(ThereAndBack(0).Forgotten(31, {21}), ElementsAre(22, 23)) << "21 stays in any case";
}

TEST(KeyframesToForget, AChangedPlaceIsNew) {
  const std::vector<KeyframeId> forgotten = ThereAndBack(1).Forgotten(30);
  EXPECT_THAT(forgotten, testing::Not(testing::Contains(21)));
  EXPECT_EQ(forgotten.size(), 3U);
}

TEST(KeyframesToForget, ViewsOfOneVisitAreThinnedEvenly) {
  Path path;
  for (int i = 0; i < 12; ++i) path.Add(0.5 * i);
  const std::vector<KeyframeId> forgotten = path.Forgotten(8);
  ASSERT_EQ(forgotten.size(), 4U);
  std::set<KeyframeId> removed(forgotten.begin(), forgotten.end());
  for (const KeyframeId id : forgotten) EXPECT_FALSE(removed.contains(KeyframeId(id.value + 1))) << id;
}

TEST(KeyframesToForget, OldestIfEachIsNeeded) {
  Path path;
  for (int i = 0; i < 6; ++i) path.Add(3.0 * i);
  EXPECT_THAT(path.Forgotten(4), ElementsAre(0, 1));
}

TEST(KeyframesToForget, KeptOnesStayEvenAboveTheLimit) {
  Path path;
  for (int i = 0; i < 6; ++i) path.Add(3.0 * i);
  EXPECT_THAT(path.Forgotten(1, {0, 4, 5}), ElementsAre(1, 2, 3));
}

// 200 laps, in which the world is replaced several times; everyday tests run a part of them.
TEST(Forgetting, BoundedMapOfAChangingWorld) {
  test::LapsOptions options;
  options.laps = test::LongTests() ? 200 : 16;
  options.replaced = 0.02;
  options.mapping.max_keyframes = 50;
  options.mapping.culling.redundant_share = 1.01;  // so that forgetting is all that bounds the map
  const test::LapsResult laps = test::RunLaps(options);
  std::cout << options.laps << " laps: at most " << laps.most.points << " points and " << laps.most.lines
            << " lines, " << 100.0 * laps.gone.back()
            << " % of the points are not there any more; error in the last lap " << laps.live_m.back()
            << " m, in the second " << laps.live_m[1] << " m\n";
  EXPECT_EQ(test::WrongWith(laps.map), "");
  EXPECT_LE(laps.most.keyframes, 50);
  EXPECT_LT(laps.most.points, 1.1 * static_cast<double>(laps.world.points().size()));
  EXPECT_LT(laps.most.lines, 1.1 * static_cast<double>(laps.world.lines().size()));
  EXPECT_LT(laps.gone.back(), 0.1);
  EXPECT_LT(laps.live_m.back(), 0.1);
  // There is a view of each place.
  for (int i = 0; i < test::ChangingWorld::kKeyframes; ++i) {
    double nearest_m = 1e9;
    for (const auto& [id, keyframe] : laps.map.keyframes()) {
      const Eigen::Vector3d apart = keyframe.T_w_kf.translation() - test::ChangingWorld::PoseAt(i).translation();
      nearest_m = std::min(nearest_m, apart.norm());
    }
    EXPECT_LT(nearest_m, 0.3) << i;
  }
}

}  // namespace
}  // namespace plslam::mapping
