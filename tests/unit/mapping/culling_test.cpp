// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/culling.h"

#include <gtest/gtest.h>

#include "core/files/archive.h"
#include "tests/unit/localisation/handmade_map.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::DescriptorOf;
using test::HandmadeMap;

constexpr double kNever = 1.01;
constexpr SessionId kSession = 7;

SE3 Pose(int i) {
  return {ExpSO3(Eigen::Vector3d(0.01 * i, 0.02 * i, -0.01 * i)), Eigen::Vector3d(0.1 * i, -0.02 * i, 0.05 * i)};
}

std::vector<Descriptor> SomeDescriptors(size_t n) {
  std::vector<Descriptor> descriptors;
  for (size_t i = 0; i < n; ++i) descriptors.push_back(DescriptorOf(i));
  return descriptors;
}

class Culling : public testing::Test {
 protected:
  Culling() {
    for (int i = 0; i < 8; ++i) m_.AddKeyframe(Pose(i));
    for (const int id : {0, 1}) Begin(SessionId(kSession.value + id), id);
  }
  void Begin(SessionId session, KeyframeId first_id) {
    MapKeyframe first;
    first.id = first_id;
    first.name.session = session;
    visits_.Add(first);
  }

  const std::vector<Descriptor> descriptors_ = SomeDescriptors(200);
  // 3 keyframes of trial, 3 observations; share 0.9 of landmarks that 3 others see.
  const CullingOptions options_{3, 3, 0.9, 3};
  HandmadeMap m_;
  Visits visits_;
};

TEST_F(Culling, RecentLandmarksWithFewObservationsAreCulled) {
  m_.Tie({1, 2}, 1, 0, descriptors_);
  m_.Tie({1, 2, 3}, 1, 1, descriptors_);
  const Segment3 segment_w{{-0.5, -0.5, 4.0}, {-0.5, 0.5, 4.0}};
  m_.PutLine(0, segment_w, descriptors_[0], {m_.SeeLine(1, segment_w, descriptors_[0])});
  RecentLandmarks trial;
  trial.Begin({{0, 1}, {0}}, kSession);
  for (int i = 0; i < 2; ++i) trial.Begin({}, kSession);
  trial.Cull(options_, visits_, m_.map);
  EXPECT_EQ(m_.map.points().size(), 2U) << "two keyframes after: still on trial";
  EXPECT_EQ(m_.map.lines().size(), 1U);
  trial.Begin({}, kSession);
  trial.Cull(options_, visits_, m_.map);
  EXPECT_EQ(m_.map.FindPoint(0), nullptr);
  EXPECT_NE(m_.map.FindPoint(1), nullptr);
  EXPECT_TRUE(m_.map.lines().empty());
}

TEST_F(Culling, OldLandmarksAreNotCulledAgain) {
  m_.Tie({1, 2, 3}, 1, 0, descriptors_);
  RecentLandmarks trial;
  trial.Begin({{0}, {}}, kSession);
  for (int i = 0; i < 3; ++i) trial.Begin({}, kSession);
  trial.Cull(options_, visits_, m_.map);
  m_.map.RemoveKeyframe(3);
  for (int i = 0; i < 20; ++i) trial.Begin({}, kSession);
  trial.Cull(options_, visits_, m_.map);
  EXPECT_NE(m_.map.FindPoint(0), nullptr);
}

TEST_F(Culling, RemovedRecentLandmarksAreHarmless) {
  m_.Tie({1}, 2, 0, descriptors_);
  RecentLandmarks trial;
  trial.Begin({{0, 1}, {5}}, kSession);
  m_.map.RemovePoint(0);
  for (int i = 0; i < 3; ++i) trial.Begin({}, kSession);
  trial.Cull(options_, visits_, m_.map);
  EXPECT_TRUE(m_.map.points().empty());
}

TEST_F(Culling, OtherSessionsDoNotAgeRecentLandmarks) {
  m_.Tie({1, 2}, 1, 0, descriptors_);
  RecentLandmarks trial;
  trial.Begin({{0}, {}}, kSession);
  for (int i = 0; i < 20; ++i) trial.Begin({}, SessionId(kSession.value + 1));
  trial.Cull(options_, visits_, m_.map);
  EXPECT_NE(m_.map.FindPoint(0), nullptr);
  for (int i = 0; i < 3; ++i) trial.Begin({}, kSession);
  trial.Cull(options_, visits_, m_.map);
  EXPECT_EQ(m_.map.FindPoint(0), nullptr);
}

TEST_F(Culling, RecentLandmarksOfAnEndedSession) {
  m_.Tie({1, 2}, 1, 0, descriptors_);
  m_.Tie({1, 2, 3}, 1, 1, descriptors_);
  RecentLandmarks trial;
  trial.Begin({{0, 1}, {}}, kSession);
  trial.Cull(options_, visits_, m_.map);
  EXPECT_EQ(m_.map.points().size(), 2U);
  const std::vector<uint8_t> none = archive::ToBytes(RecentLandmarks());
  EXPECT_NE(archive::ToBytes(trial), none);
  for (int i = 0; i < static_cast<int>(kRunningSessions); ++i) Begin(SessionId(100 + i), 10 + i);
  trial.Cull(options_, visits_, m_.map);
  EXPECT_EQ(m_.map.FindPoint(0), nullptr);
  EXPECT_NE(m_.map.FindPoint(1), nullptr);
  EXPECT_EQ(archive::ToBytes(trial), none) << "nothing is remembered of it";
}

TEST_F(Culling, RedundantKeyframeIsCulled) {
  m_.Tie({2, 3, 4, 5}, 30, 0, descriptors_);
  EXPECT_EQ(RemoveRedundantKeyframes({2}, options_, m_.features, m_.map), (std::vector<KeyframeId>{2}));
  EXPECT_EQ(m_.map.FindKeyframe(2), nullptr);
  EXPECT_FALSE(m_.features.contains(2));
  EXPECT_EQ(m_.map.points().size(), 30U);
  EXPECT_EQ(test::WrongWith(m_.map), "");
}

TEST_F(Culling, KeyframeWithASixthOfItsOwnIsKept) {
  m_.Tie({2, 3, 4, 5}, 25, 0, descriptors_);
  m_.Tie({2, 3, 4}, 5, 25, descriptors_);
  EXPECT_TRUE(RemoveRedundantKeyframes({2}, options_, m_.features, m_.map).empty());
  EXPECT_NE(m_.map.FindKeyframe(2), nullptr);
}

TEST_F(Culling, KeyframeWithoutLandmarksAndTheFirstStay) {
  m_.Tie({0, 3, 4, 5}, 30, 0, descriptors_);
  EXPECT_TRUE(RemoveRedundantKeyframes({0, 1}, options_, m_.features, m_.map).empty());
  EXPECT_EQ(m_.map.keyframes().size(), 8U);
}

TEST_F(Culling, FirstOfALaterSessionStays) {
  m_.Tie({2, 3, 4, 5}, 30, 0, descriptors_);
  MapKeyframe first = *m_.map.FindKeyframe(2);
  first.previous_id = -1;
  m_.map.Put(first);
  EXPECT_TRUE(RemoveRedundantKeyframes({2}, options_, m_.features, m_.map).empty());
}

TEST_F(Culling, EndsOfALoopStay) {
  m_.Tie({1, 2, 3, 4, 5}, 30, 0, descriptors_);
  LoopEdge loop;
  loop.old_keyframe_id = 1;
  loop.keyframe_id = 2;
  m_.map.Add(loop);
  EXPECT_EQ(RemoveRedundantKeyframes({1, 2, 3}, options_, m_.features, m_.map), (std::vector<KeyframeId>{3}));
}

// Five observe everything: after two have been removed, the rest have fewer than three others.
TEST_F(Culling, RedundancyIsCheckedAfterEachRemoval) {
  m_.Tie({1, 2, 3, 4, 5}, 30, 0, descriptors_);
  EXPECT_EQ(RemoveRedundantKeyframes({1, 2, 3, 4, 5}, options_, m_.features, m_.map),
            (std::vector<KeyframeId>{1, 2}));
}

TEST_F(Culling, RedundantShareAboveOneKeepsAll) {
  m_.Tie({1, 2, 3, 4, 5}, 30, 0, descriptors_);
  CullingOptions never = options_;
  never.redundant_share = kNever;
  EXPECT_TRUE(RemoveRedundantKeyframes({1, 2, 3}, never, m_.features, m_.map).empty());
}

TEST_F(Culling, OdometryEdgeSpansACulledKeyframe) {
  m_.Tie({2, 3, 4, 5, 6}, 30, 0, descriptors_);
  // Motions as measured, with their own covariances; not computed from the poses.
  std::vector<SE3> motion;
  std::vector<Matrix6d> covariance;
  for (const int id : {2, 3, 4}) {
    MapKeyframe keyframe = *m_.map.FindKeyframe(id);
    keyframe.T_prevkf_kf = Pose(static_cast<int>(id)) * SE3(ExpSO3(Eigen::Vector3d(0.3, 0.2, 0.1)), {1.0, 2.0, 3.0});
    Matrix6d A = Matrix6d::Random();
    keyframe.relative_covariance = 1e-3 * (A * A.transpose() + Matrix6d::Identity());
    m_.map.Put(keyframe);
    motion.push_back(keyframe.T_prevkf_kf);
    covariance.push_back(keyframe.relative_covariance);
  }
  ASSERT_EQ(RemoveRedundantKeyframes({2, 3}, options_, m_.features, m_.map), (std::vector<KeyframeId>{2, 3}));
  const MapKeyframe& after = *m_.map.FindKeyframe(4);
  EXPECT_EQ(after.previous_id, 1);
  EXPECT_LT((after.T_prevkf_kf.Inverse() * motion[0] * motion[1] * motion[2]).Log().norm(), 1e-12);
  // The slow way: the derivatives of the whole by each part, numerically.
  Matrix6d expected = Matrix6d::Zero();
  const SE3 whole = motion[0] * motion[1] * motion[2];
  for (size_t part = 0; part < 3; ++part) {
    Matrix6d J;
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 6; ++k) {
      SE3 moved;
      for (size_t i = 0; i < 3; ++i) {
        moved = moved * motion[i];
        if (i == part) moved = moved * SE3::Exp(kStep * Vector6d::Unit(k));
      }
      J.col(k) = (whole.Inverse() * moved).Log() / kStep;
    }
    expected += J * covariance[part] * J.transpose();
  }
  EXPECT_LT((after.relative_covariance - expected).norm(), 1e-4 * expected.norm())
      << after.relative_covariance << "\n\n"
      << expected;
}

}  // namespace
}  // namespace plslam::mapping
