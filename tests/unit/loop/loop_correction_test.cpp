// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/loop_correction.h"

#include <gtest/gtest.h>

#include <numbers>

namespace plslam::test {
namespace {

constexpr double kSquareRadius_m = 10.0;

SE3 OnCircle(int i, int n) {
  const double a = 2.0 * std::numbers::pi * i / n;
  return {ExpSO3({0.0, a, 0.0}), {kSquareRadius_m * (1.0 - std::cos(a)), 0.0, kSquareRadius_m * std::sin(a)}};
}

// Keyframes around a circle whose steps all have the same error; and their true poses.
struct Lap {
  Map map;
  std::vector<SE3> truth;

  Lap(int n, const Vector6d& error, int64_t first_id = 0, SessionId session = 1) {
    for (int i = 0; i < n; ++i) Add(i, n, error, first_id, session);
  }

  void Add(int i, int n, const Vector6d& error, int64_t first_id, SessionId session) {
    MapKeyframe keyframe;
    keyframe.id = KeyframeId(first_id + i);
    keyframe.name.session = session;
    keyframe.name.number = i;
    truth.push_back(OnCircle(i, n));
    keyframe.T_w_kf = truth.back();
    if (i > 0) {
      keyframe.previous_id = keyframe.parent_id = KeyframeId(keyframe.id.value - 1);
      keyframe.T_prevkf_kf = OnCircle(i - 1, n).Inverse() * OnCircle(i, n) * SE3::Exp(error);
      keyframe.relative_covariance = 1e-4 * Matrix6d::Identity();
      keyframe.T_w_kf = map.FindKeyframe(keyframe.previous_id)->T_w_kf * keyframe.T_prevkf_kf;
    }
    map.Put(keyframe);
  }

  double WorstError_m(const std::vector<CorrectedPose>& poses) const {
    double worst = 0.0;
    for (size_t i = 0; i < poses.size(); ++i) {
      worst = std::max(worst, (poses[i].T_w_kf.translation() - truth[i].translation()).norm());
    }
    return worst;
  }
};

Vector6d SmallDrift() {
  Vector6d x;
  x << 0.002, 0.001, -0.003, 0.0002, 0.0005, -0.0003;
  return x;
}

LoopEdge EdgeBetween(KeyframeId a, KeyframeId b, const SE3& T_a_b) {
  LoopEdge edge;
  edge.old_keyframe_id = a;
  edge.keyframe_id = b;
  edge.T_old_kf = T_a_b;
  edge.covariance = 1e-6 * Matrix6d::Identity();
  return edge;
}

TEST(CloseLoop, DriftOfALapIsSharedOut) {
  Lap lap(80, SmallDrift());
  const auto before_m = (lap.map.FindKeyframe(79)->T_w_kf.translation() - lap.truth[79].translation()).norm();
  const auto poses = loop::CloseLoop(lap.map, EdgeBetween(0, 79, lap.truth[0].Inverse() * lap.truth[79]), {});
  ASSERT_TRUE(poses.has_value());
  ASSERT_EQ(poses->size(), 80U);
  EXPECT_EQ(poses->front().T_w_kf.matrix(), lap.map.FindKeyframe(0)->T_w_kf.matrix());
  EXPECT_GT(before_m, 0.3);
  EXPECT_LT((poses->back().T_w_kf.translation() - lap.truth[79].translation()).norm(), 0.01);
  EXPECT_LT(lap.WorstError_m(*poses), 0.5 * before_m);
}

TEST(CloseLoop, WithoutDriftNothingMoves) {
  Lap lap(40, Vector6d::Zero());
  const auto poses = loop::CloseLoop(lap.map, EdgeBetween(0, 39, lap.truth[0].Inverse() * lap.truth[39]), {});
  ASSERT_TRUE(poses.has_value());
  EXPECT_LT(lap.WorstError_m(*poses), 1e-9);
}

TEST(CloseLoop, LoopContradictedByAnEarlierLoop) {
  Lap lap(80, SmallDrift());
  // Closed before, and the map shows it.
  const auto closed = loop::CloseLoop(lap.map, EdgeBetween(0, 79, lap.truth[0].Inverse() * lap.truth[79]), {});
  ASSERT_TRUE(closed.has_value());
  for (const CorrectedPose& pose : *closed) lap.map.SetPose(pose.keyframe_id, pose.T_w_kf, Matrix6d::Zero());
  lap.map.Add(EdgeBetween(0, 79, lap.truth[0].Inverse() * lap.truth[79]));
  const SE3 T_2_78 = lap.truth[2].Inverse() * lap.truth[78];
  EXPECT_TRUE(loop::CloseLoop(lap.map, EdgeBetween(2, 78, T_2_78), {}).has_value());
  const SE3 wrong(Eigen::Quaterniond::Identity(), {2.8, 0.0, 0.0});
  EXPECT_FALSE(loop::CloseLoop(lap.map, EdgeBetween(2, 78, T_2_78 * wrong), {}).has_value());
}

// Keyframes 0 to 19, and 20 to 34 of another session that lies anywhere.
Lap LapAndAnother() {
  Lap both(20, Vector6d::Zero());
  const Lap second(15, Vector6d::Zero(), 20, 2);
  const SE3 T_w_second(ExpSO3({0.1, 1.0, -0.2}), {30.0, -2.0, 5.0});
  for (const auto& [id, keyframe] : second.map.keyframes()) {
    MapKeyframe moved = keyframe;
    moved.T_w_kf = T_w_second * keyframe.T_w_kf;
    both.map.Put(moved);
  }
  return both;
}

// The loop is between 5 and 22.
void ExpectLaterPartMovedAsAWhole(const Map& map, const SE3& T_5_22, const std::vector<CorrectedPose>& poses,
                                  double tolerance) {
  ASSERT_EQ(poses.size(), 35U);
  for (int i = 0; i < 20; ++i) {
    EXPECT_LT((poses[i].T_w_kf.Inverse() * map.FindKeyframe(i)->T_w_kf).Log().norm(), tolerance) << i;
  }
  const SE3 T_w_22 = map.FindKeyframe(5)->T_w_kf * T_5_22;
  EXPECT_LT((poses[22].T_w_kf.Inverse() * T_w_22).Log().norm(), tolerance);
  const SE3 T_22_30 = map.FindKeyframe(22)->T_w_kf.Inverse() * map.FindKeyframe(30)->T_w_kf;
  EXPECT_LT((poses[30].T_w_kf.Inverse() * T_w_22 * T_22_30).Log().norm(), tolerance);
}

TEST(CloseLoop, YoungerPartMovesToTheOlderAsAWhole) {
  const Lap both = LapAndAnother();
  const SE3 T_5_22(ExpSO3({0.0, 0.1, 0.0}), {0.3, 0.0, 0.1});
  // In both directions.
  for (const LoopEdge& edge : {EdgeBetween(5, 22, T_5_22), EdgeBetween(22, 5, T_5_22.Inverse())}) {
    const auto poses = loop::CloseLoop(both.map, edge, {});
    ASSERT_TRUE(poses.has_value());
    ExpectLaterPartMovedAsAWhole(both.map, T_5_22, *poses, 1e-7);
  }
}

// The tracker was lost before keyframe 20, and went on in the same session.
TEST(CloseLoop, PartAfterAnUnknownStepMovesAsAWhole) {
  Lap both = LapAndAnother();
  MapKeyframe first = *both.map.FindKeyframe(20);
  first.previous_id = first.parent_id = 19;
  first.relative_covariance.diagonal() << 100.0, 100.0, 100.0, 1.0, 1.0, 1.0;
  both.map.Put(first);
  const SE3 T_5_22(ExpSO3({0.0, 0.1, 0.0}), {0.3, 0.0, 0.1});
  const auto poses = loop::CloseLoop(both.map, EdgeBetween(5, 22, T_5_22), {});
  ASSERT_TRUE(poses.has_value());
  ExpectLaterPartMovedAsAWhole(both.map, T_5_22, *poses, 1e-6);
}

// For example the part of another robot, which is still mapping.
TEST(CloseLoop, OtherPartIsNotCorrected) {
  const Lap both = LapAndAnother();
  const auto in_first = loop::CloseLoop(both.map, EdgeBetween(0, 19, both.truth[0].Inverse() * both.truth[19]), {});
  ASSERT_TRUE(in_first.has_value());
  ASSERT_EQ(in_first->size(), 20U);
  EXPECT_EQ(in_first->back().keyframe_id, 19);
  const SE3 T_20_34 = both.map.FindKeyframe(20)->T_w_kf.Inverse() * both.map.FindKeyframe(34)->T_w_kf;
  const auto in_second = loop::CloseLoop(both.map, EdgeBetween(20, 34, T_20_34 * SE3::Exp(SmallDrift())), {});
  ASSERT_TRUE(in_second.has_value());
  ASSERT_EQ(in_second->size(), 15U);
  for (const CorrectedPose& pose : *in_second) {
    EXPECT_GE(pose.keyframe_id, 20);
    EXPECT_LT((pose.T_w_kf.Inverse() * both.map.FindKeyframe(pose.keyframe_id)->T_w_kf).Log().norm(), 0.01);
  }
}

TEST(CloseLoop, ZeroCovarianceIsRefused) {
  Lap lap(10, Vector6d::Zero());
  LoopEdge edge = EdgeBetween(0, 9, SE3());
  edge.covariance.setZero();
  EXPECT_FALSE(loop::CloseLoop(lap.map, edge, {}).has_value());
}

}  // namespace
}  // namespace plslam::test
