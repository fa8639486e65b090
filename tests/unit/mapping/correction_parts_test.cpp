// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/map/map_graph.h"
#include "mapping_process/corrections/correction.h"
#include "mapping_process/corrections/loop_fusion.h"
#include "mapping_process/insertion/observations.h"
#include "tests/unit/localisation/handmade_map.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::DescriptorOf;
using test::FeatureWorld;
using test::HandmadeMap;

SE3 At(double x_m, double yaw_rad = 0.0) {
  return {ExpSO3(Eigen::Vector3d(0.0, yaw_rad, 0.0)), Eigen::Vector3d(x_m, 0.0, 0.0)};
}

void ExpectSame(const SE3& a, const SE3& b) { EXPECT_LT((a.Inverse() * b).Log().norm(), 1e-12); }

/// Five keyframes side by side; 4 hangs on 1 in the spanning tree, the others on the one before.
class PosesAfterACorrection : public testing::Test {
 protected:
  PosesAfterACorrection() {
    for (int i = 0; i < 5; ++i) m_.AddKeyframe(At(i));
    MapKeyframe last = *m_.map.FindKeyframe(4);
    last.parent_id = 1;
    m_.map.Put(last);
  }
  HandmadeMap m_;
};

TEST_F(PosesAfterACorrection, UnnamedKeyframesMoveWithTheirParent) {
  const auto poses = PosesAfter({{1, At(1.0, 0.5)}, {3, At(30.0)}}, m_.map);
  ASSERT_EQ(poses.size(), 4U);
  EXPECT_FALSE(poses.contains(0));
  ExpectSame(poses.at(1), At(1.0, 0.5));
  ExpectSame(poses.at(2), At(1.0, 0.5) * At(1.0));
  ExpectSame(poses.at(3), At(30.0));
  ExpectSame(poses.at(4), At(1.0, 0.5) * At(3.0));
}

TEST_F(PosesAfterACorrection, UnnamedKeyframesMoveWithThePreviousOne) {
  const auto poses = PosesAfter({{3, At(30.0)}}, m_.map);
  ASSERT_EQ(poses.size(), 2U);
  ExpectSame(poses.at(4), At(31.0));
}

TEST_F(PosesAfterACorrection, NothingNamedMovesNothing) {
  EXPECT_TRUE(PosesAfter({}, m_.map).empty());
  EXPECT_TRUE(PosesAfter({{77, At(3.0)}}, m_.map).empty());
}

/// Three keyframes that observe one place.
class MovedLandmarks : public testing::Test {
 protected:
  MovedLandmarks() {
    for (int i = 0; i < 3; ++i) m_.AddKeyframe(At(0.1 * i));
  }
  void Move(const std::map<KeyframeId, SE3>& poses) {
    MoveKeyframes(poses, m_.features, FeatureWorld::Camera(), m_.map);
    EXPECT_EQ(test::WrongWith(m_.map), "");
  }
  const Eigen::Vector3d p_{0.4, -0.2, 3.0};
  const Segment3 segment_{{-0.4, -0.5, 3.0}, {-0.5, 0.6, 3.3}};
  const SE3 T_{ExpSO3(Eigen::Vector3d(0.1, -0.4, 0.2)), Eigen::Vector3d(3.0, 1.0, -2.0)};
  HandmadeMap m_;
};

TEST_F(MovedLandmarks, MoveRigidlyWithRotatedCovariances) {
  constexpr double kSinglePrecision = 1e-7;
  m_.PutPoint(0, p_, DescriptorOf(1), {m_.SeePoint(2, p_, DescriptorOf(1))});
  m_.PutLine(0, segment_, DescriptorOf(2), {m_.SeeLine(2, segment_, DescriptorOf(2))});
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();
  m_.map.SetPosition(0, p_, covariance);
  m_.map.SetSegment(0, segment_, covariance, 2.0 * covariance);
  Move({{2, T_ * At(0.2)}});
  const Eigen::Matrix3d turned = T_.R() * covariance * T_.R().transpose();
  EXPECT_LT((m_.map.FindPoint(0)->p_w - T_ * p_).norm(), 1e-12);
  EXPECT_LT((m_.map.FindPoint(0)->covariance.matrix() - turned).norm(), kSinglePrecision * turned.norm());
  EXPECT_LT((m_.map.FindLine(0)->segment_w.p - T_ * segment_.p).norm(), 1e-12);
  EXPECT_LT((m_.map.FindLine(0)->segment_w.q - T_ * segment_.q).norm(), 1e-12);
  EXPECT_LT((m_.map.FindLine(0)->covariance_p.matrix() - turned).norm(), kSinglePrecision * turned.norm());
  EXPECT_LT((m_.map.FindLine(0)->covariance_q.matrix() - 2.0 * turned).norm(),
            2.0 * kSinglePrecision * turned.norm());
  EXPECT_EQ(m_.map.FindPoint(0)->observations.size(), 1U);
}

// Two keyframes hold it against one that moves, whichever is newest.
TEST_F(MovedLandmarks, MoveWithTheSideOfMoreObservations) {
  std::vector<Observation> of_point;
  std::vector<Observation> of_line;
  for (int id = 0; id < 3; ++id) {
    of_point.push_back(m_.SeePoint(id, p_, DescriptorOf(1)));
    of_line.push_back(m_.SeeLine(id, segment_, DescriptorOf(2)));
  }
  m_.PutPoint(0, p_, DescriptorOf(1), of_point);
  m_.PutLine(0, segment_, DescriptorOf(2), of_line);
  const SE3 aside = At(0.3, 0.05);
  Move({{2, aside * At(0.2)}});
  EXPECT_LT((m_.map.FindPoint(0)->p_w - p_).norm(), 1e-12);
  EXPECT_LT((m_.map.FindLine(0)->segment_w.p - segment_.p).norm(), 1e-12);
  // The second follows: now these two are the majority.
  Move({{1, aside * At(0.1)}});
  EXPECT_LT((m_.map.FindPoint(0)->p_w - aside * p_).norm(), 1e-12);
  EXPECT_LT((m_.map.FindLine(0)->segment_w.p - aside * segment_.p).norm(), 1e-12);
}

TEST_F(MovedLandmarks, ObservationsBehindTheCameraAreRemoved) {
  m_.PutPoint(0, p_, DescriptorOf(1),
              {m_.SeePoint(0, p_, DescriptorOf(1)), m_.SeePoint(1, p_, DescriptorOf(1)),
               m_.SeePoint(2, p_, DescriptorOf(1))});
  m_.PutLine(0, segment_, DescriptorOf(2),
             {m_.SeeLine(0, segment_, DescriptorOf(2)), m_.SeeLine(1, segment_, DescriptorOf(2)),
              m_.SeeLine(2, segment_, DescriptorOf(2))});
  Move({{2, At(0.2, 3.1)}});
  EXPECT_EQ(m_.map.FindPoint(0)->observations.size(), 2U);
  EXPECT_EQ(m_.map.FindLine(0)->observations.size(), 2U);
}

TEST_F(MovedLandmarks, UnchangedPosesGiveNoChanges) {
  m_.PutPoint(0, p_, DescriptorOf(1), {m_.SeePoint(2, p_, DescriptorOf(1))});
  m_.map.TakeChanges();
  Move({{0, m_.map.FindKeyframe(0)->T_w_kf}, {2, m_.map.FindKeyframe(2)->T_w_kf}});
  EXPECT_TRUE(m_.map.TakeChanges().empty());
}

TEST(ObservationErrors, AgreeWithTheirDefinition) {
  const StereoCamera camera = FeatureWorld::Camera();
  MapPoint point;
  point.p_w = {0.3, 0.2, 2.5};
  const Eigen::Vector3d uvd = camera.ProjectStereo(point.p_w);
  StereoPoint seen;
  seen.left.px = uvd.head<2>() + Eigen::Vector2d(0.6, -0.8);
  seen.sigma_px = 0.5;
  seen.disparity_px = uvd.z() + 0.9;
  seen.sigma_disparity_px = 0.3;
  EXPECT_NEAR(ObservationError(point, seen, SE3(), camera), 1.0 / 0.25 + 9.0, 1e-9);
  seen.disparity_px = -1.0;
  EXPECT_NEAR(ObservationError(point, seen, SE3(), camera), 4.0, 1e-9);
  point.p_w.z() = -1.0;
  EXPECT_EQ(ObservationError(point, seen, SE3(), camera), kMostObservationError);
  point.p_w.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ObservationError(point, seen, SE3(), camera), kMostObservationError);
  EXPECT_FALSE(IsNear(point, seen, SE3(), camera));
}

TEST(ObservationErrors, LinesAreEndpointDistances) {
  const StereoCamera camera = FeatureWorld::Camera();
  MapLine line;
  line.segment_w = {{-0.5, -0.5, 2.0}, {-0.5, 0.5, 2.0}};
  StereoLine seen;
  seen.left.segment = {camera.Project(line.segment_w.p) + Eigen::Vector2d(1.5, 0.0),
                       camera.Project(line.segment_w.q) + Eigen::Vector2d(1.5, 0.0)};
  seen.sigma_px = 0.75;
  EXPECT_NEAR(ObservationError(line, seen, SE3(), camera), 8.0, 1e-6);
  EXPECT_TRUE(IsNear(line, seen, SE3(), camera));
  seen.left.segment.p.x() += 200.0;
  seen.left.segment.q.x() += 200.0;
  EXPECT_EQ(ObservationError(line, seen, SE3(), camera), kMostObservationError);
  EXPECT_FALSE(IsNear(line, seen, SE3(), camera));
  seen.left.segment.q = seen.left.segment.p;
  EXPECT_LE(ObservationError(line, seen, SE3(), camera), kMostObservationError);
  EXPECT_FALSE(IsNear(line, seen, SE3(), camera));
}

TEST_F(MovedLandmarks, PairsOfALoopAreFusedAlsoInAChain) {
  for (int id = 0; id < 3; ++id) {
    m_.PutPoint(id, p_, DescriptorOf(1), {m_.SeePoint(id, p_, DescriptorOf(1))});
    m_.PutLine(id, segment_, DescriptorOf(2), {m_.SeeLine(id, segment_, DescriptorOf(2))});
  }
  const std::vector<SameLandmarks> pairs = {{1, 2}, {2, 0}, {0, 1}, {1, 99}, {2, 2}};
  FusePairs(pairs, pairs, m_.features, m_.map);
  ASSERT_EQ(test::WrongWith(m_.map), "");
  ASSERT_EQ(m_.map.points().size(), 1U);
  ASSERT_EQ(m_.map.lines().size(), 1U);
  EXPECT_EQ(m_.map.FindPoint(0)->observations.size(), 3U);
  EXPECT_EQ(m_.map.FindLine(0)->observations.size(), 3U);
}

TEST(MapParts, AreConnectedByTreeSessionAndLoops) {
  HandmadeMap m;
  for (int i = 0; i < 6; ++i) m.AddKeyframe(At(i));
  MapKeyframe begins = *m.map.FindKeyframe(3);
  begins.previous_id = begins.parent_id = -1;
  m.map.Put(begins);
  EXPECT_EQ(MapGraph(m.map).Component(1, MapGraph::Edges::kAll), (std::set<KeyframeId>{0, 1, 2}));
  EXPECT_EQ(MapGraph(m.map).Component(5, MapGraph::Edges::kAll), (std::set<KeyframeId>{3, 4, 5}));
  m.map.Add(LoopEdge{99, 4, SE3()});
  EXPECT_EQ(MapGraph(m.map).Component(5, MapGraph::Edges::kAll), (std::set<KeyframeId>{3, 4, 5}));
  m.map.Add(LoopEdge{0, 4, SE3()});
  EXPECT_EQ(MapGraph(m.map).Component(5, MapGraph::Edges::kAll).size(), 6U);
}

}  // namespace
}  // namespace plslam::mapping
