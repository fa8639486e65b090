// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/recorder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/text_file.h"
#include "tests/unit/run/frame_poses.h"

namespace plslam {
namespace {

TEST(Recorder, KeepsReorderedFramesInOrder) {
  Recorder recorder;
  for (const int64_t id : {5, 1, 3}) EXPECT_TRUE(recorder.AddPose(SomePose(id)));
  std::vector<int64_t> ids;
  for (const auto& [id, frame] : recorder.frames()) ids.push_back(id);
  EXPECT_EQ(ids, (std::vector<int64_t>{1, 3, 5}));
}

TEST(Recorder, LaterPoseOfAFrameCounts) {
  Recorder recorder;
  FramePose pose = SomePose(4, TrackingState::kLost);
  pose.keyframe_id = 0;
  pose.counts.skipped_frames = 2;
  recorder.AddPose(pose);
  EXPECT_EQ(recorder.Tally(false).lost, 1);
  EXPECT_EQ(recorder.keyframes(), 1);
  EXPECT_EQ(recorder.Tally(false).skipped, 2);
  recorder.AddPose(SomePose(4));
  EXPECT_EQ(recorder.frames().size(), 1u);
  EXPECT_EQ(recorder.Tally(false).lost, 0);
  EXPECT_EQ(recorder.keyframes(), 0);
  EXPECT_EQ(recorder.Tally(false).skipped, 0);
}

TEST(Recorder, NonsenseIsRefused) {
  Recorder recorder;
  FramePose pose = SomePose(0);
  pose.T_odom_c = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(NAN, 0, 0));
  EXPECT_FALSE(recorder.AddPose(pose));
  pose = SomePose(0);
  pose.T_w_odom = SE3(Eigen::Quaterniond(0, 0, 0, NAN), Eigen::Vector3d::Zero());
  EXPECT_FALSE(recorder.AddPose(pose));
  pose = SomePose(0);
  pose.covariance(2, 3) = INFINITY;
  EXPECT_FALSE(recorder.AddPose(pose));
  EXPECT_FALSE(recorder.AddPose(SomePose(-1)));
  EXPECT_FALSE(recorder.AddPose(SomePose(0, static_cast<TrackingState>(5))));
  EXPECT_FALSE(recorder.AddPose(SomePose(0, static_cast<TrackingState>(-1))));
  pose = SomePose(0);
  pose.counts.skipped_frames = -3;
  EXPECT_FALSE(recorder.AddPose(pose));
  EXPECT_FALSE(recorder.AddTruth(-1, {}));
  EXPECT_FALSE(recorder.AddTruth(0, {0, SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, NAN, 0))}));
  EXPECT_TRUE(recorder.frames().empty());
  EXPECT_TRUE(recorder.truth().empty());
}

TEST(Recorder, CompleteIfEachFrameHasAPoseOrWasSkipped) {
  Recorder recorder;
  recorder.AddPose(SomePose(0));
  EXPECT_FALSE(recorder.IsComplete()) << "the stream still runs";
  recorder.SetEnd(4);
  EXPECT_FALSE(recorder.IsComplete());
  FramePose last = SomePose(3);
  last.counts.skipped_frames = 2;
  recorder.AddPose(last);
  EXPECT_TRUE(recorder.IsComplete());
}

TEST(Recorder, LastPoseEndsTheWaitForLostOnes) {
  Recorder recorder;
  recorder.AddPose(SomePose(0));
  EXPECT_FALSE(recorder.HasLastPose()) << "the stream still runs";
  recorder.SetEnd(4);
  EXPECT_FALSE(recorder.HasLastPose());
  recorder.AddPose(SomePose(3));
  EXPECT_FALSE(recorder.IsComplete());
  EXPECT_TRUE(recorder.HasLastPose()) << "frames 1 and 2 were lost before the tracker";
}

TEST(Recorder, EmptyStreamIsComplete) {
  Recorder recorder;
  recorder.SetEnd(0);
  EXPECT_TRUE(recorder.IsComplete());
}

TEST(Recorder, StagesMayVaryBetweenFrames) {
  Recorder recorder;
  recorder.AddPose(SomePose(0));
  FramePose pose = SomePose(1);
  pose.stages_ms = {{"lines", 3.0}};
  recorder.AddPose(pose);
  EXPECT_EQ(recorder.stage_names(), (std::vector<std::string>{"orb", "pose", "lines"}));
  const FrameRecord frame = recorder.frames().Find(1).value();
  ASSERT_EQ(frame.stages_ms.size(), 3u);
  EXPECT_TRUE(std::isnan(frame.stages_ms[0]));
  EXPECT_EQ(frame.stages_ms[2], 3.0F);
}

TEST(Recorder, StageNamesWithoutEndAreBounded) {
  Recorder recorder;
  for (int i = 0; i < 1000; ++i) {
    FramePose pose = SomePose(i);
    pose.stages_ms = {{"stage" + std::to_string(i), 1.0}};
    recorder.AddPose(pose);
  }
  EXPECT_EQ(recorder.stage_names().size(), 32u);
}

TEST(Recorder, PackedCovarianceKeepsSevenDigitsAndSymmetry) {
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = std::sin(i + 1.0) * 1e-3;
  const Matrix6d covariance = A * A.transpose();
  const Matrix6d unpacked = PackedCovariance(covariance).Unpack();
  EXPECT_EQ(unpacked, unpacked.transpose());
  EXPECT_LT((unpacked - covariance).norm(), 1e-6 * covariance.norm());
}

TEST(Recorder, AFrameCostsLessThanHalfAKilobyte) { EXPECT_LE(sizeof(StoredFrame), 500u); }

TEST(Recorder, FramesInAFileAreTheSame) {
  const ScratchFolder folder;
  Recorder in_memory;
  Recorder in_file(folder.Path(""));
  for (int i = 0; i < 5000; ++i) {
    // Some late, and some twice.
    FramePose pose = SomePose(i % 7 == 3 ? i / 2 : i);
    pose.T_odom_c = SE3::Exp(Vector6d::Constant(1e-3 * i));
    pose.stages_ms = {{"orb", 0.1 * i}};
    for (Recorder* recorder : {&in_memory, &in_file}) {
      EXPECT_TRUE(recorder->AddPose(pose));
      EXPECT_TRUE(recorder->AddTruth(pose.frame_id, {pose.t_ns, pose.T_odom_c}));
    }
  }
  EXPECT_EQ(in_file.failure(), "");
  EXPECT_EQ(in_file.keyframes(), in_memory.keyframes());
  ASSERT_EQ(in_file.frames().size(), in_memory.frames().size());
  auto expected = in_memory.frames().begin();
  for (const auto& [frame_id, frame] : in_file.frames()) {
    const auto& [id, other] = *expected;
    ASSERT_EQ(frame_id, id);
    ASSERT_EQ(frame.T_odom_c.matrix(), other.T_odom_c.matrix());
    ASSERT_EQ(frame.stages_ms, other.stages_ms);
    ASSERT_EQ(in_file.truth().Find(id)->T_w_l.matrix(), other.T_odom_c.matrix());
    ++expected;
  }
}

TEST(Recorder, FramesStayInMemoryIfTheFolderCannotBeWritten) {
  Recorder recorder("/nowhere/at/all");
  for (int i = 0; i < 3000; ++i) EXPECT_TRUE(recorder.AddPose(SomePose(i)));
  EXPECT_EQ(recorder.failure(), "/nowhere/at/all: a temporary file cannot be written: No such file or directory");
  EXPECT_EQ(recorder.frames().size(), 3000u);
  EXPECT_EQ(recorder.frames().Find(7)->t_ns, SomePose(7).t_ns);
}

TEST(Recorder, StateNames) {
  EXPECT_EQ(TrackingStateName(TrackingState::kLost), "lost");
  EXPECT_EQ(TrackingStateName(static_cast<TrackingState>(99)), "unknown");
}

}  // namespace
}  // namespace plslam
