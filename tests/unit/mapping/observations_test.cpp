// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/observations.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/unit/localisation/handmade_map.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::DescriptorOf;
using test::HandmadeMap;

SE3 StandingAt(double x) { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0.0, 0.0)}; }

// The positions of keyframes, points and lines are arbitrary here.
const Eigen::Vector3d kSeenPoint(0.2, 0.1, 4.0);
const Segment3 kSeenSegment{{-0.5, -0.5, 4.0}, {-0.5, 0.5, 4.0}};

/// The feature types side by side.
struct Points {
  using Kind = PointType;
  static Observation See(HandmadeMap& m, KeyframeId keyframe_id, const Descriptor& d) {
    return m.SeePoint(keyframe_id, kSeenPoint, d);
  }
  static void Put(HandmadeMap& m, LandmarkId id, const Descriptor& d, std::vector<Observation> observations) {
    m.PutPoint(id, kSeenPoint, d, std::move(observations));
  }
};
struct Lines {
  using Kind = LineType;
  static Observation See(HandmadeMap& m, KeyframeId keyframe_id, const Descriptor& d) {
    return m.SeeLine(keyframe_id, kSeenSegment, d);
  }
  static void Put(HandmadeMap& m, LandmarkId id, const Descriptor& d, std::vector<Observation> observations) {
    m.PutLine(id, kSeenSegment, d, std::move(observations));
  }
};

template <class Of>
class Observations : public testing::Test {
 protected:
  Observations() {
    for (int i = 0; i < 6; ++i) m_.AddKeyframe(StandingAt(0.1 * i));
  }
  // Puts a landmark that these keyframes observe with different descriptors.
  void Put(LandmarkId id, const std::vector<KeyframeId>& keyframes) {
    std::vector<Observation> observations;
    for (const KeyframeId k : keyframes) observations.push_back(Of::See(m_, k, DescriptorOf(Seed(k, id))));
    Of::Put(m_, id, DescriptorOf(Seed(keyframes.front(), id)), observations);
  }
  std::vector<KeyframeId> SeenBy(LandmarkId id) const {
    std::vector<KeyframeId> keyframes;
    for (const Observation& observation : Of::Kind::Find(m_.map, id)->observations)
      keyframes.push_back(observation.keyframe_id());
    return keyframes;
  }

  static uint64_t Seed(KeyframeId keyframe_id, LandmarkId id) {
    return static_cast<uint64_t>(100 * keyframe_id.value + id.value);
  }

  HandmadeMap m_;
};

using Kinds = testing::Types<Points, Lines>;
TYPED_TEST_SUITE(Observations, Kinds);

TYPED_TEST(Observations, AddedInOrderOfKeyframes) {
  using Kind = typename TypeParam::Kind;
  this->Put(0, {0, 4});
  EXPECT_TRUE(AddObservation<Kind>(0, TypeParam::See(this->m_, 2, DescriptorOf(1)), this->m_.features, this->m_.map));
  EXPECT_TRUE(AddObservation<Kind>(0, TypeParam::See(this->m_, 5, DescriptorOf(2)), this->m_.features, this->m_.map));
  EXPECT_EQ(this->SeenBy(0), (std::vector<KeyframeId>{0, 2, 4, 5}));
}

TYPED_TEST(Observations, RefusedForASeenLandmarkOrAUsedFeature) {
  using Kind = typename TypeParam::Kind;
  this->Put(0, {0, 1});
  this->Put(1, {2});
  EXPECT_FALSE(
      AddObservation<Kind>(0, TypeParam::See(this->m_, 1, DescriptorOf(1)), this->m_.features, this->m_.map));
  EXPECT_FALSE(
      AddObservation<Kind>(0, Kind::Find(this->m_.map, 1)->observations[0], this->m_.features, this->m_.map));
  EXPECT_FALSE(
      AddObservation<Kind>(77, TypeParam::See(this->m_, 1, DescriptorOf(1)), this->m_.features, this->m_.map));
  EXPECT_EQ(this->SeenBy(0), (std::vector<KeyframeId>{0, 1}));
  EXPECT_EQ(this->SeenBy(1), (std::vector<KeyframeId>{2}));
}

TYPED_TEST(Observations, LandmarkIsRemovedWithItsLastObservation) {
  using Kind = typename TypeParam::Kind;
  this->Put(0, {0, 1, 3});
  DropObservation<Kind>(0, 1, this->m_.features, this->m_.map);
  EXPECT_EQ(this->SeenBy(0), (std::vector<KeyframeId>{0, 3}));
  DropObservation<Kind>(0, 1, this->m_.features, this->m_.map);
  EXPECT_EQ(this->SeenBy(0), (std::vector<KeyframeId>{0, 3})) << "an observation that is not there";
  DropObservation<Kind>(0, 0, this->m_.features, this->m_.map);
  EXPECT_EQ(Kind::Find(this->m_.map, 0)->descriptor, DescriptorOf(300)) << "of the observation that is left";
  DropObservation<Kind>(0, 3, this->m_.features, this->m_.map);
  EXPECT_EQ(Kind::Find(this->m_.map, 0), nullptr);
  DropObservation<Kind>(0, 3, this->m_.features, this->m_.map);
}

TYPED_TEST(Observations, FusedUnderTheSmallerId) {
  using Kind = typename TypeParam::Kind;
  for (const bool swapped : {false, true}) {
    this->Put(10, {0, 3});
    this->Put(11, {1, 2, 4});
    ASSERT_TRUE(Fuse<Kind>(swapped ? 11 : 10, swapped ? 10 : 11, this->m_.features, this->m_.map));
    EXPECT_EQ(this->SeenBy(10), (std::vector<KeyframeId>{0, 1, 2, 3, 4}));
    EXPECT_EQ(Kind::Find(this->m_.map, 11), nullptr);
    EXPECT_EQ(test::WrongWith(this->m_.map), "");
  }
}

TYPED_TEST(Observations, NotFusedIfAKeyframeSeesBoth) {
  using Kind = typename TypeParam::Kind;
  this->Put(0, {0, 1});
  this->Put(1, {1, 2});
  EXPECT_FALSE(Fuse<Kind>(0, 1, this->m_.features, this->m_.map));
  EXPECT_FALSE(Fuse<Kind>(0, 0, this->m_.features, this->m_.map));
  EXPECT_FALSE(Fuse<Kind>(0, 5, this->m_.features, this->m_.map));
  EXPECT_EQ(this->SeenBy(0), (std::vector<KeyframeId>{0, 1}));
  EXPECT_EQ(this->SeenBy(1), (std::vector<KeyframeId>{1, 2}));
}

// All sums of distances, the smallest, and of equal ones the newest.
TYPED_TEST(Observations, DescriptorIsTheMedoid) {
  using Kind = typename TypeParam::Kind;
  std::mt19937_64 generator(5);
  for (int round = 0; round < 50; ++round) {
    HandmadeMap m;
    std::vector<Descriptor> seen;
    const Descriptor base = DescriptorOf(static_cast<uint64_t>(round));
    const int n = 2 + static_cast<int>(generator() % 6);
    for (int k = 0; k < n; ++k) {
      m.AddKeyframe(StandingAt(0.1 * k));
      Descriptor d = base;
      const int flips = static_cast<int>(generator() % 40);
      for (int f = 0; f < flips; ++f) d[generator() % 4] ^= 1ULL << (generator() % 64);
      const Observation observation = TypeParam::See(m, k, d);
      if (k == 0) {
        TypeParam::Put(m, 0, d, {observation});
      } else {
        ASSERT_TRUE(AddObservation<Kind>(0, observation, m.features, m.map));
      }
      seen.push_back(d);
      std::vector<int> sums;
      for (const Descriptor& a : seen) {
        int sum = 0;
        for (const Descriptor& b : seen) sum += HammingDistance(a, b);
        sums.push_back(sum);
      }
      size_t best = 0;
      for (size_t i = 0; i < sums.size(); ++i) best = sums[i] <= sums[best] ? i : best;
      ASSERT_EQ(Kind::Find(m.map, 0)->descriptor, seen[best])
          << "round " << round << ", " << seen.size() << " observations";
    }
  }
}

TEST(ObservationsOfPoints, OctaveAngleAndDepthComeWithTheDescriptor) {
  HandmadeMap m;
  m.AddKeyframe(StandingAt(0.0));
  m.AddKeyframe({Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, 0.0, 1.0)});
  const Descriptor d = DescriptorOf(1);
  m.PutPoint(0, kSeenPoint, d, {m.SeePoint(0, kSeenPoint, d)});
  const Observation nearer = m.SeePoint(1, kSeenPoint, d);
  test::ChangeFeatures(m.features, 1, [](StereoFeatures& of) {
    of.points[0].left.octave = 2;
    of.points[0].left.angle_rad = 0.5F;
  });
  ASSERT_TRUE(AddObservation<PointType>(0, nearer, m.features, m.map));
  const MapPoint& point = *m.map.FindPoint(0);
  EXPECT_EQ(point.octave, 2) << "the newer of two equals";
  EXPECT_EQ(point.angle_rad, 0.5F);
  EXPECT_NEAR(point.depth_m, 3.0, 1e-12);
}

}  // namespace
}  // namespace plslam::mapping
