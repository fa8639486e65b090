// SPDX-License-Identifier: BSD-3-Clause
#include "core/localisation/projection_search.h"

#include <gtest/gtest.h>

#include "tests/unit/localisation/handmade_map.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam {
namespace {

using test::DescriptorOf;
using test::FeatureWorld;
using test::HandmadeMap;

constexpr double kRadius_px = 8.0;
const Eigen::Vector3d kPoint(0.3, -0.2, 4.0);
const Segment3 kSegment{{-0.5, -0.5, 4.0}, {-0.4, 0.5, 4.0}};

/// One point and one line that keyframe 0 sees; keyframe 1 looks for them.
class ProjectionSearch : public testing::Test {
 protected:
  ProjectionSearch() {
    m_.AddKeyframe(SE3());
    m_.AddKeyframe(T_w_1_);
    m_.PutPoint(5, kPoint, look_, {m_.SeePoint(0, kPoint, look_)});
    m_.PutLine(6, kSegment, look_, {m_.SeeLine(0, kSegment, look_)});
    m_.SeePoint(1, {0.9, 0.9, 5.0}, DescriptorOf(50));
    m_.SeePoint(1, kPoint, look_);
    m_.SeeLine(1, {{0.9, -0.5, 4.0}, {0.9, 0.5, 4.0}}, DescriptorOf(60));
    m_.SeeLine(1, kSegment, look_);
  }
  std::vector<LandmarkFeature> Points(const SE3& T_w_kf, const std::vector<char>& eligible = {1, 1}) const {
    return SearchPoints(m_.map, {5}, T_w_kf, m_.features.at(1).points, eligible, kRadius_px, FeatureWorld::Camera(),
                        LocalisationOptions());
  }
  std::vector<LandmarkFeature> Lines(const SE3& T_w_kf, const std::vector<char>& eligible = {1, 1}) const {
    return SearchLines(m_.map, {6}, T_w_kf, m_.features.at(1).lines, eligible, kRadius_px, FeatureWorld::Camera(),
                       LocalisationOptions());
  }

  const Descriptor look_ = DescriptorOf(9);
  const SE3 T_w_1_{ExpSO3(Eigen::Vector3d(0.0, 0.05, 0.02)), Eigen::Vector3d(0.2, 0.1, 0.3)};
  HandmadeMap m_;
};

TEST_F(ProjectionSearch, FindsFeaturesAtProjectedLandmarks) {
  ASSERT_EQ(Points(T_w_1_).size(), 1U);
  EXPECT_EQ(Points(T_w_1_)[0].landmark_id, 5);
  EXPECT_EQ(Points(T_w_1_)[0].feature, 1);
  ASSERT_EQ(Lines(T_w_1_).size(), 1U);
  EXPECT_EQ(Lines(T_w_1_)[0].landmark_id, 6);
  EXPECT_EQ(Lines(T_w_1_)[0].feature, 1);
}

TEST_F(ProjectionSearch, OnlyWithinTheRadius) {
  const auto turned = [this](double px) {
    return T_w_1_ * SE3(ExpSO3(Eigen::Vector3d(0.0, px / 400.0, 0.0)), Eigen::Vector3d::Zero());
  };
  EXPECT_EQ(Points(turned(6.0)).size(), 1U);
  EXPECT_EQ(Lines(turned(6.0)).size(), 1U);
  EXPECT_TRUE(Points(turned(12.0)).empty());
  EXPECT_TRUE(Lines(turned(12.0)).empty());
}

TEST_F(ProjectionSearch, IneligibleFeaturesAreNotMatched) {
  EXPECT_TRUE(Points(T_w_1_, {1, 0}).empty());
  EXPECT_TRUE(Lines(T_w_1_, {1, 0}).empty());
  EXPECT_EQ(Points(T_w_1_, {0, 1}).size(), 1U);
  EXPECT_EQ(Lines(T_w_1_, {0, 1}).at(0).feature, 1) << "the place in the whole list";
}

TEST_F(ProjectionSearch, AnotherDescriptorIsNoMatch) {
  test::ChangeFeatures(m_.features, 1, [](StereoFeatures& of) {
    of.points[1].left.descriptor = of.lines[1].left.descriptor = DescriptorOf(77);
  });
  EXPECT_TRUE(Points(T_w_1_).empty());
  EXPECT_TRUE(Lines(T_w_1_).empty());
}

// Without the depth test, a pinhole would project points behind the camera, upside down.
TEST_F(ProjectionSearch, LandmarksBehindOrOutOfViewAreNotSearched) {
  const SE3 behind(Eigen::Quaterniond::Identity(), 2.0 * kPoint);
  const Eigen::Vector2d mirrored = FeatureWorld::Camera().Project(behind.Inverse() * kPoint);
  test::ChangeFeatures(m_.features, 1, [&](StereoFeatures& of) { of.points[1].left.px = mirrored; });
  EXPECT_TRUE(Points(behind).empty());
  EXPECT_TRUE(Lines(behind).empty());
  const SE3 aside(Eigen::Quaterniond::Identity(), Eigen::Vector3d(20.0, 0.0, 0.0));
  EXPECT_TRUE(Points(aside).empty());
  EXPECT_TRUE(Lines(aside).empty());
}

TEST_F(ProjectionSearch, LineThroughTheCameraCentreIsNotSearched) {
  const SE3 on_line(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), kSegment.q - kSegment.p),
                    kSegment.p - 2.0 * (kSegment.q - kSegment.p));
  EXPECT_TRUE(Lines(on_line).empty());
  const SE3 within(on_line.rotation(), 0.5 * (kSegment.p + kSegment.q));
  EXPECT_TRUE(Lines(within).empty());
}

// A corner of octave 3 from 4 m away is one of octave 0 from 2.3 m only where it appears larger.
TEST_F(ProjectionSearch, OctaveFollowsTheDistance) {
  MapPoint point = *m_.map.FindPoint(5);
  point.octave = 3;
  m_.map.Put(point);
  EXPECT_TRUE(Points(T_w_1_).empty()) << "seen in octave 0 from nearly as far";
  test::ChangeFeatures(m_.features, 1, [](StereoFeatures& of) { of.points[1].left.octave = 3; });
  EXPECT_EQ(Points(T_w_1_).size(), 1U);
}

}  // namespace
}  // namespace plslam
