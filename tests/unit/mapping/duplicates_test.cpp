// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/duplicates.h"

#include <gtest/gtest.h>

#include "tests/unit/localisation/handmade_map.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::DescriptorOf;
using test::FeatureWorld;
using test::HandmadeMap;

const Eigen::Vector3d kPoint(0.33, 0.81, 3.0);
const Segment3 kSegment{{-1.0, -0.9, 3.0}, {-1.05, 0.8, 3.3}};
constexpr int kFirst = 100;

/// Two neighbours that share 30 points, and a point for which each has a separate landmark.
class Duplicates : public testing::Test {
 protected:
  Duplicates() {
    for (uint64_t i = 0; i < 40; ++i) descriptors_.push_back(DescriptorOf(i));
    m_.AddKeyframe(SE3());
    m_.AddKeyframe({ExpSO3(Eigen::Vector3d(0.0, 0.02, 0.0)), Eigen::Vector3d(0.1, 0.0, 0.05)});
    m_.Tie({0, 1}, 30, 0, descriptors_);
  }
  void PutPointAt(LandmarkId id, KeyframeId keyframe_id, const Eigen::Vector3d& p_w) {
    m_.PutPoint(id, p_w, look_, {m_.SeePoint(keyframe_id, p_w, look_)});
  }
  void PutLineAt(LandmarkId id, KeyframeId keyframe_id, const Segment3& segment_w) {
    m_.PutLine(id, segment_w, look_, {m_.SeeLine(keyframe_id, segment_w, look_)});
  }
  void Merge() {
    MergeWithNeighbours(1, m_.features, FeatureWorld::Camera(), MappingOptions(), m_.map);
    ASSERT_EQ(test::WrongWith(m_.map), "");
  }

  std::vector<Descriptor> descriptors_;
  const Descriptor look_ = DescriptorOf(999);
  HandmadeMap m_;
};

TEST_F(Duplicates, DuplicatePointsOfNeighboursAreFused) {
  PutPointAt(kFirst, 0, kPoint);
  PutPointAt(kFirst + 1, 1, kPoint + Eigen::Vector3d(0.002, -0.001, 0.02));
  Merge();
  ASSERT_NE(m_.map.FindPoint(kFirst), nullptr);
  EXPECT_EQ(m_.map.FindPoint(kFirst)->observations.size(), 2U);
  EXPECT_EQ(m_.map.FindPoint(kFirst + 1), nullptr);
  EXPECT_EQ(m_.map.points().size(), 31U);
}

TEST_F(Duplicates, DuplicateLinesCutDifferentlyAreFused) {
  PutLineAt(kFirst, 0, kSegment);
  const Eigen::Vector3d along = kSegment.q - kSegment.p;
  PutLineAt(kFirst + 1, 1, {kSegment.p + 0.3 * along, kSegment.q});
  Merge();
  ASSERT_NE(m_.map.FindLine(kFirst), nullptr);
  EXPECT_EQ(m_.map.FindLine(kFirst)->observations.size(), 2U);
  EXPECT_EQ(m_.map.FindLine(kFirst + 1), nullptr);
}

// On one ray of keyframe 1, so at one pixel of its image, and with similar descriptors.
TEST_F(Duplicates, OccludingPointsAreNotFused) {
  PutPointAt(kFirst, 0, kPoint);
  const SE3 T_w_1 = m_.map.FindKeyframe(1)->T_w_kf;
  PutPointAt(kFirst + 1, 1, T_w_1 * (1.8 * (T_w_1.Inverse() * kPoint)));
  Merge();
  EXPECT_NE(m_.map.FindPoint(kFirst), nullptr);
  EXPECT_NE(m_.map.FindPoint(kFirst + 1), nullptr);
}

TEST_F(Duplicates, OccludingLinesAreNotFused) {
  PutLineAt(kFirst, 0, kSegment);
  const SE3 T_w_1 = m_.map.FindKeyframe(1)->T_w_kf;
  PutLineAt(kFirst + 1, 1,
            {T_w_1 * (1.8 * (T_w_1.Inverse() * kSegment.p)), T_w_1 * (1.8 * (T_w_1.Inverse() * kSegment.q))});
  Merge();
  EXPECT_NE(m_.map.FindLine(kFirst), nullptr);
  EXPECT_NE(m_.map.FindLine(kFirst + 1), nullptr);
}

TEST_F(Duplicates, UnassociatedFeaturesBecomeObservations) {
  PutPointAt(kFirst, 0, kPoint);
  m_.SeePoint(1, kPoint, look_);
  PutLineAt(kFirst, 1, kSegment);
  m_.SeeLine(0, kSegment, look_);
  Merge();
  EXPECT_EQ(m_.map.FindPoint(kFirst)->observations.size(), 2U);
  EXPECT_EQ(m_.map.FindLine(kFirst)->observations.size(), 2U);
}

TEST_F(Duplicates, PointsSeenApartByAKeyframeAreNotFused) {
  PutPointAt(kFirst, 0, kPoint);
  const Eigen::Vector3d beside = kPoint + Eigen::Vector3d(0.005, 0.0, 0.0);
  const Observation in_0 = m_.SeePoint(0, beside, look_);
  m_.PutPoint(kFirst + 1, beside, look_, {in_0, m_.SeePoint(1, beside, look_)});
  Merge();
  EXPECT_NE(m_.map.FindPoint(kFirst), nullptr);
  EXPECT_NE(m_.map.FindPoint(kFirst + 1), nullptr);
}

}  // namespace
}  // namespace plslam::mapping
