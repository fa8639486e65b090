// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/final_trajectory.h"

#include <gtest/gtest.h>

#include "core/run/run_writer.h"
#include "tests/unit/run/frame_poses.h"

namespace plslam {
namespace {

SE3 Pose(double x, double y, double z, double yaw_rad) {
  return SE3(Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY())), {x, y, z});
}

void ExpectSame(const SE3& a, const SE3& b) {
  EXPECT_LT((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), 1e-12) << a.matrix() << "\n" << b.matrix();
}

/// A map whose keyframes 0, 1, ... are the frames 2, 6 and 16 of session 7, each moved by `Correction`.
SE3 Correction(int i) { return Pose(0.1 * i, -0.2 * i, 0.05, 0.03 * i); }

constexpr int64_t kKeyframes[] = {2, 6, 16};

Map SomeMap() {
  Map map;
  for (int i = 0; i < 3; ++i) {
    MapKeyframe keyframe;
    keyframe.id = i;
    keyframe.name.session = 7;
    keyframe.name.number = i;
    keyframe.frame_id = FrameId(kKeyframes[i]);
    keyframe.t_ns = SomePose(keyframe.frame_id.value).t_ns;
    keyframe.T_odom_kf = SomePose(keyframe.frame_id.value).T_odom_c;
    keyframe.T_w_kf = Correction(i) * keyframe.T_odom_kf;
    keyframe.parent_id = i - 1;
    map.Put(keyframe);
  }
  return map;
}

Recorder SomeRun(int64_t n_frames) {
  Recorder recorder;
  for (int64_t i = 0; i < n_frames; ++i) {
    FramePose pose = SomePose(i);
    pose.T_w_odom = Pose(9.0, 9.0, 9.0, 1.0);
    pose.keyframe_id = i % 5 == 0 ? i / 5 : -1;
    recorder.AddPose(pose);
  }
  return recorder;
}

SE3 Final(const Map& map, int64_t frame_id, SessionId session = 7) {
  const Recorder recorder = SomeRun(30);
  FrameRecord frame = recorder.frames().Find(frame_id).value();
  frame.session = session;
  return FinalPoses(map, recorder)(FrameId(frame_id), frame);
}

TEST(FinalPoses, KeyframesHaveTheirPoseOfTheMap) {
  const Map map = SomeMap();
  for (int i = 0; i < 3; ++i) ExpectSame(Final(map, kKeyframes[i]), map.FindKeyframe(i)->T_w_kf);
}

TEST(FinalPoses, FramesBetweenKeyframesAreInterpolated) {
  const SE3 T_odom_c = SomePose(5).T_odom_c;
  const SE3 first = Correction(0) * T_odom_c, second = Correction(1) * T_odom_c;
  const SE3 blended = Final(SomeMap(), 5);
  const Eigen::Vector3d t = 0.25 * first.translation() + 0.75 * second.translation();
  EXPECT_LT((blended.translation() - t).norm(), 1e-12);
  EXPECT_NEAR(first.rotation().angularDistance(blended.rotation()), 0.75 * 0.03, 1e-12);
  EXPECT_NEAR(second.rotation().angularDistance(blended.rotation()), 0.25 * 0.03, 1e-12);
}

TEST(FinalPoses, OuterFramesFollowTheNearestKeyframe) {
  ExpectSame(Final(SomeMap(), 0), Correction(0) * SomePose(0).T_odom_c);
  ExpectSame(Final(SomeMap(), 29), Correction(2) * SomePose(29).T_odom_c);
}

TEST(FinalPoses, FramesOfACulledKeyframeUseItsNeighbours) {
  Map map = SomeMap();
  map.RemoveKeyframe(1);
  const SE3 T_odom_c = SomePose(6).T_odom_c;
  const SE3 blended = Final(map, 6);
  const double share = 4.0 / 14.0;
  const Eigen::Vector3d t =
      (1.0 - share) * (Correction(0) * T_odom_c).translation() + share * (Correction(2) * T_odom_c).translation();
  EXPECT_LT((blended.translation() - t).norm(), 1e-12);
}

TEST(FinalPoses, RememberedKeyframeMovesWithItsCarrier) {
  Map map = SomeMap();
  map.RememberRemoved();
  const SE3 T_carrier_kf = map.FindKeyframe(0)->T_w_kf.Inverse() * map.FindKeyframe(1)->T_w_kf;
  map.RemoveKeyframe(1);
  ExpectSame(Final(map, 6), map.FindKeyframe(0)->T_w_kf * T_carrier_kf);
  const SE3 T_w_kf = Pose(3.0, 2.0, 1.0, 0.5);
  map.Move({{0, T_w_kf}});
  ExpectSame(Final(map, 6), T_w_kf * T_carrier_kf);
}

TEST(FinalPoses, NoInterpolationAcrossLostFrames) {
  const Map map = SomeMap();
  Recorder recorder;
  for (int64_t i = 0; i < 30; ++i) {
    FramePose pose = SomePose(i);
    if (i >= 9 && i < 12) pose.state = TrackingState::kLost;
    recorder.AddPose(pose);
  }
  const FinalPoses final_poses(map, recorder);
  for (const int64_t i : {7, 8}) {
    ExpectSame(final_poses(FrameId(i), recorder.frames().Find(i).value()), Correction(1) * SomePose(i).T_odom_c);
  }
  for (const int64_t i : {12, 15}) {
    ExpectSame(final_poses(FrameId(i), recorder.frames().Find(i).value()), Correction(2) * SomePose(i).T_odom_c);
  }
}

TEST(FinalPoses, PublishedPosesWithoutKeyframes) {
  ExpectSame(Final(SomeMap(), 5, 8), Pose(9.0, 9.0, 9.0, 1.0) * SomePose(5).T_odom_c);
  ExpectSame(Final(Map(), 5), Pose(9.0, 9.0, 9.0, 1.0) * SomePose(5).T_odom_c);
}

TEST(KeyframeTrajectory, KeyframesOfRecordedSessionsInTheOrderOfTime) {
  Map map = SomeMap();
  MapKeyframe other = *map.FindKeyframe(0);
  other.id = 3;
  other.name.session = 99;
  map.Put(other);
  other.id = 4;
  other.name.session = 7;
  other.t_ns = 5;
  map.Put(other);
  other.id = 5;
  map.Put(other);
  const Trajectory trajectory = KeyframeTrajectory(map, SomeRun(20));
  ASSERT_EQ(trajectory.size(), 4U);
  EXPECT_EQ(trajectory[0].t_ns, 5);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(trajectory[static_cast<size_t>(i) + 1].t_ns, SomePose(kKeyframes[i]).t_ns);
    ExpectSame(trajectory[static_cast<size_t>(i) + 1].T_a_b, map.FindKeyframe(i)->T_w_kf);
  }
}

TEST(BuildTrajectories, FinalAndLivePosesOfTheSameFrames) {
  const Eigen::Quaterniond q_l_c(Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, 2, 3).normalized()));
  const SE3 T_c_l(q_l_c.conjugate(), Eigen::Vector3d::Zero());
  const plslam::Run run = RunOf(SomeRun(20), SomeMap(), q_l_c);
  ASSERT_EQ(run.trajectory->size(), 20U);
  ASSERT_EQ(run.live->size(), 20U);
  EXPECT_EQ(run.covariance->size(), 20U);
  ExpectSame(run.live->at(6).T_a_b, Pose(9.0, 9.0, 9.0, 1.0) * SomePose(6).T_odom_c * T_c_l);
  ExpectSame(run.trajectory->at(6).T_a_b, Correction(1) * SomePose(6).T_odom_c * T_c_l);
  ASSERT_EQ(run.keyframes->size(), 3U) << "those of the map, not those of the poses";
  ExpectSame(run.keyframes->at(1).T_a_b, run.trajectory->at(6).T_a_b);
}

}  // namespace
}  // namespace plslam
