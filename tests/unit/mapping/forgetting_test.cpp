// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/forgetting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "mapping_process/mapper.h"
#include "tests/support/long_tests.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::FeatureWorld;
using testing::ElementsAre;
using testing::IsEmpty;

/// A metre apart along z; every one after the other.
class Path {
 public:
  void Add(double z_m, double yaw_deg = 0.0) {
    MapKeyframe keyframe;
    keyframe.id = n_;
    keyframe.session_keyframe_id = keyframe.frame_id = n_;
    keyframe.previous_id = keyframe.parent_id = n_ - 1;
    keyframe.T_w_kf = SE3(ExpSO3({0.0, yaw_deg * kRadPerDeg, 0.0}), {0.0, 0.0, z_m});
    if (n_ > 0) keyframe.T_prevkf_kf = map_.FindKeyframe(n_ - 1)->T_w_kf.Inverse() * keyframe.T_w_kf;
    map_.Put(keyframe);
    ++n_;
  }
  std::vector<int64_t> Forgotten(size_t max_keyframes, const std::set<int64_t>& kept = {}) const {
    return KeyframesToForget(map_, max_keyframes,
                             [&](const MapKeyframe& keyframe) { return kept.contains(keyframe.id); });
  }

 private:
  int64_t n_ = 0;
  Map map_;
};

TEST(KeyframesToForget, NoneAsLongAsTheyFit) {
  Path path;
  for (int i = 0; i < 5; ++i) path.Add(i);
  EXPECT_THAT(path.Forgotten(5), IsEmpty());
}

TEST(KeyframesToForget, OldestThatANewerOneReplaces) {
  Path path;
  for (int i = 0; i < 6; ++i) path.Add(i);
  // Again past 2, 3 and 4, 30 cm from the first positions.
  path.Add(20.0);
  for (int i = 2; i < 5; ++i) path.Add(i + 0.3);
  EXPECT_THAT(path.Forgotten(9), ElementsAre(2));
  EXPECT_THAT(path.Forgotten(8), ElementsAre(2, 3));
  EXPECT_THAT(path.Forgotten(8, {2}), ElementsAre(3, 4)) << "2 stays in any case";
}

TEST(KeyframesToForget, NoneIsReplacedByTheNextOnTheSameVisit) {
  Path path;
  path.Add(-50.0);
  for (int i = 0; i < 8; ++i) path.Add(0.9 * i);
  path.Add(50.0);
  path.Add(0.1);
  EXPECT_THAT(path.Forgotten(10), ElementsAre(1))
      << "the others at the beginning of a stretch would follow one another";
  EXPECT_THAT(path.Forgotten(9), ElementsAre(1, 2));
}

TEST(KeyframesToForget, AnotherViewingDirectionIsNoReplacement) {
  Path path;
  for (int i = 0; i < 4; ++i) path.Add(i);
  path.Add(20.0);
  for (int i = 3; i >= 0; --i) path.Add(i, 180.0);
  path.Add(2.0);
  EXPECT_THAT(path.Forgotten(9), ElementsAre(1));
  EXPECT_THAT(path.Forgotten(8, {1}), ElementsAre(2, 3));
}

TEST(KeyframesToForget, OldestIfNoneIsReplaced) {
  Path path;
  for (int i = 0; i < 6; ++i) path.Add(3.0 * i);
  EXPECT_THAT(path.Forgotten(4), ElementsAre(0, 1));
  EXPECT_THAT(path.Forgotten(1, {0, 4, 5}), ElementsAre(1, 2, 3)) << "more stay than there is room for";
}

/// A world in which some landmarks are replaced after each lap, and a closed path through it.
class ChangingWorld {
 public:
  static constexpr int kKeyframes = 36;  // a lap

  ChangingWorld() : world_(Counts(), 1) {}

  SE3 PoseAt(int i) const {
    const double angle = 2.0 * std::numbers::pi * i / kKeyframes;
    return {ExpSO3({0.0, angle, 0.0}), {1.2 * std::sin(angle), 0.0, 1.2 * (1.0 - std::cos(angle))}};
  }
  const FeatureWorld& world() const { return world_; }

  /// Replaces some landmarks by new ones.
  void Change(double share, uint64_t seed) {
    const FeatureWorld other(Counts(), seed);
    std::mt19937_64 random(seed);
    std::vector<FeatureWorld::Point> points = world_.points();
    std::vector<FeatureWorld::Line> lines = world_.lines();
    const auto is_replaced = [&] { return static_cast<double>(random() % 1000) < 1000.0 * share; };
    for (size_t i = 0; i < points.size(); ++i) {
      if (is_replaced()) points[i] = other.points()[i];
    }
    for (size_t i = 0; i < lines.size(); ++i) {
      if (is_replaced()) lines[i] = other.lines()[i];
    }
    world_ = FeatureWorld(std::move(points), std::move(lines), 20.0);
  }

 private:
  static FeatureWorld::Counts Counts() { return {.points = 500, .lines = 60}; }

  FeatureWorld world_;
};

/// Returns the ids by which a tracker that is localised in the map names its features.
template <class Landmarks>
std::map<Descriptor, int64_t> ByDescriptor(const Landmarks& landmarks) {
  std::map<Descriptor, int64_t> ids;
  for (const auto& [id, landmark] : landmarks) ids[landmark.descriptor] = id;
  return ids;
}

template <class Feature>
std::vector<int64_t> MapIds(const std::vector<Feature>& features, const std::map<Descriptor, int64_t>& ids) {
  std::vector<int64_t> map_ids;
  for (const Feature& feature : features) {
    const auto known = ids.find(feature.left.descriptor);
    map_ids.push_back(known == ids.end() ? -1 : known->second);
  }
  return map_ids;
}

/// Returns the share of the map's landmarks that are not in the world any more.
double ShareOfGone(const Map& map, const FeatureWorld& world) {
  std::set<Descriptor> there;
  for (const FeatureWorld::Point& point : world.points()) there.insert(point.descriptor);
  const auto is_gone = [&](const auto& entry) { return !there.contains(entry.second.descriptor); };
  const auto n = std::count_if(map.points().begin(), map.points().end(), is_gone);
  return static_cast<double>(n) / static_cast<double>(map.points().size());
}

// 200 laps, in which the world is replaced twice; everyday tests run a part of them.
TEST(Forgetting, BoundedMapOfAChangingWorld) {
  const int laps = test::LongTests() ? 200 : 16;
  constexpr int kBudget = 50;
  ChangingWorld changing;
  MappingOptions options;
  options.max_keyframes = kBudget;
  options.culling.redundant_share = 1.01;  // so that forgetting is all that bounds the map
  Mapper mapper(FeatureWorld::Camera(), options);
  std::mt19937_64 random(3);
  std::normal_distribution<double> gauss;
  Keyframe previous;
  double worst_m = 0.0;
  MapTotals most;
  for (int i = 0; i < laps * ChangingWorld::kKeyframes; ++i) {
    if (i > 0 && i % ChangingWorld::kKeyframes == 0) changing.Change(0.02, 1000 + static_cast<uint64_t>(i));
    const SE3 T_w_kf = changing.PoseAt(i);
    const SE3 step = i == 0 ? SE3() : changing.PoseAt(i - 1).Inverse() * T_w_kf;
    Vector6d error;
    for (int k = 0; k < 6; ++k) error[k] = (k < 3 ? 0.01 : 0.004) * gauss(random);
    const SE3 T_odom_kf = i == 0 ? T_w_kf : previous.T_odom_kf * step * SE3::Exp(error);
    Keyframe keyframe = test::MakeKeyframe(i == 0 ? nullptr : &previous, T_odom_kf,
                                           changing.world().Observe(T_w_kf, 0.4, static_cast<uint64_t>(i)));
    keyframe.point_map_ids = MapIds(keyframe.features.points, ByDescriptor(mapper.map().points()));
    keyframe.line_map_ids = MapIds(keyframe.features.lines, ByDescriptor(mapper.map().lines()));
    ASSERT_TRUE(test::MapOne(keyframe, mapper));
    ASSERT_LE(mapper.map().keyframes().size(), static_cast<size_t>(kBudget));
    mapper.TakeUpdate();
    const SE3& T_w_mapped = mapper.map().keyframes().rbegin()->second.T_w_kf;
    worst_m = std::max(worst_m, (T_w_mapped.translation() - T_w_kf.translation()).norm());
    const MapTotals totals = mapper.map().Totals();
    most.points = std::max(most.points, totals.points);
    most.lines = std::max(most.lines, totals.lines);
    previous = keyframe;
  }
  const Map& map = mapper.map();
  EXPECT_EQ(test::WrongWith(map), "");
  const double gone = ShareOfGone(map, changing.world());
  std::cout << laps << " laps: at most " << most.points << " points and " << most.lines << " lines, " << 100.0 * gone
            << " % of the points are not there any more; the newest keyframe is at most " << worst_m << " m off\n";
  EXPECT_LT(most.points, 1.1 * static_cast<double>(changing.world().points().size()));
  EXPECT_LT(most.lines, 1.1 * static_cast<double>(changing.world().lines().size()));
  EXPECT_LT(gone, 0.1);
  EXPECT_LT(worst_m, 0.1);
  // There is a view of each place.
  for (int i = 0; i < ChangingWorld::kKeyframes; ++i) {
    const auto distance_m = [&](const auto& entry) {
      return (entry.second.T_w_kf.translation() - changing.PoseAt(i).translation()).norm();
    };
    double nearest_m = 1e9;
    for (const auto& entry : map.keyframes()) nearest_m = std::min(nearest_m, distance_m(entry));
    EXPECT_LT(nearest_m, 0.3) << i;
  }
  // The remaining map can be saved and continued.
  Mapper again(FeatureWorld::Camera(), options, DecodeMap(EncodeMap(mapper.Store())));
  EXPECT_EQ(test::Encoded(again.map()), test::Encoded(map));
}

}  // namespace
}  // namespace plslam::mapping
