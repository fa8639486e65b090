// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/missed_landmarks.h"

#include <gtest/gtest.h>

#include <set>

#include "mapping_process/mapper_state.h"
#include "tests/support/feature_world.h"

namespace plslam::mapping {
namespace {

using test::FeatureWorld;

/// A camera that comes to the same place again and again and shows some of the points there.
class Place {
 public:
  static constexpr int kPoints = 100;

  /// Leaves to 5 m away, looking to the side, comes back, and shows all points but these; at most `n_shown`.
  void Visit(const std::set<int>& gone, int n_shown = kPoints) {
    for (int i = 1; i <= 20; ++i) Add(i <= 10 ? 0.5 * i : 10.0 - 0.5 * i, true);
    const KeyframeId id = Add(0.0, false);
    int32_t feature = 0;
    for (int point_id = 0; point_id < kPoints; ++point_id) {
      if (gone.contains(point_id) || feature == n_shown) continue;
      MapPoint point;
      if (map_.FindPoint(point_id) != nullptr) point = *map_.FindPoint(point_id);
      point.id = point_id;
      point.p_w = {0.02 * (point_id % 10), 0.02 * (point_id / 10), 4.0};
      point.depth_m = 4.0;
      point.observations.push_back({id, feature++});
      map_.Put(point);
    }
    missed_.Compare(id, visits_, FeatureWorld::Camera(), map_);
  }
  /// Continues from a state of the two, as bytes.
  void Restart() {
    MapperState state;
    state.visits = visits_;
    state.missed_landmarks = missed_;
    state = DecodeState(EncodeState(state));
    visits_ = state.visits;
    missed_ = state.missed_landmarks;
  }
  bool Has(LandmarkId point_id) const { return map_.FindPoint(point_id) != nullptr; }

 private:
  KeyframeId Add(double x_m, bool looks_aside) {
    MapKeyframe keyframe;
    keyframe.id = n_++;
    keyframe.previous_id = n_ - 2;
    keyframe.T_w_kf = SE3(ExpSO3({0.0, looks_aside ? 2.0 : 0.0, 0.0}), {x_m, 0.0, 0.0});
    if (keyframe.id > 0)
      keyframe.T_prevkf_kf = map_.FindKeyframe(keyframe.previous_id)->T_w_kf.Inverse() * keyframe.T_w_kf;
    map_.Put(keyframe);
    visits_.Add(keyframe);
    return keyframe.id;
  }

  int n_ = 0;
  Map map_;
  Visits visits_;
  MissedLandmarks missed_;
};

TEST(MissedLandmarks, RemovedOnceTwoVisitsMissedThem) {
  Place place;
  place.Visit({});
  place.Visit({3, 4});
  EXPECT_TRUE(place.Has(3));
  place.Visit({3, 4});
  EXPECT_FALSE(place.Has(3));
  EXPECT_FALSE(place.Has(4));
  EXPECT_TRUE(place.Has(5));
}

TEST(MissedLandmarks, FoundAgainInBetweenIsKept) {
  Place place;
  place.Visit({});
  place.Visit({3});
  place.Visit({});
  place.Visit({3});
  EXPECT_TRUE(place.Has(3));
  place.Visit({3});
  EXPECT_FALSE(place.Has(3));
}

TEST(MissedLandmarks, DarkImagesProveNothing) {
  Place place;
  place.Visit({});
  for (int i = 0; i < 10; ++i) place.Visit({3}, 20);
  EXPECT_TRUE(place.Has(3));
  EXPECT_TRUE(place.Has(99));
}

TEST(MissedLandmarks, AreCountedInTheState) {
  Place place;
  place.Visit({});
  place.Visit({3});
  place.Restart();
  EXPECT_TRUE(place.Has(3));
  place.Visit({3});
  EXPECT_FALSE(place.Has(3));
}

}  // namespace
}  // namespace plslam::mapping
