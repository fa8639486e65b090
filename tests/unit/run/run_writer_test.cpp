// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/run_writer.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <string_view>

#include "tests/support/text_file.h"
#include "tests/unit/run/frame_poses.h"

namespace plslam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string TextOf(const std::function<void(const AppendText&)>& write) {
  std::string text;
  write([&text](std::string_view part) { text += part; });
  return text;
}

std::vector<int64_t> FramesOf(const Trajectory& trajectory) {
  std::vector<int64_t> frames;
  for (const TrajectoryPose& pose : trajectory) frames.push_back((pose.t_ns - 1'000'000'000) / 100'000'000);
  return frames;
}

TEST(Outputs, LostFramesAndAdjacentMotionsAreLeftOut) {
  Recorder recorder;
  for (int i = 0; i < 6; ++i) {
    FramePose pose = SomePose(i, i == 3 ? TrackingState::kLost : TrackingState::kTracking);
    pose.keyframe_id = i % 2 == 0 ? i / 2 : -1;
    recorder.AddPose(pose);
  }
  const plslam::Run run = RunOf(recorder, Map(), Eigen::Quaterniond::Identity());
  EXPECT_THAT(FramesOf(*run.trajectory), ElementsAre(0, 1, 2, 4, 5));
  EXPECT_THAT(FramesOf(*run.keyframes), ElementsAre(0, 2, 4));
  EXPECT_EQ(run.covariance->size(), 5u);
  std::vector<int64_t> motions;
  for (const PoseCovariance& row : *run.motion_covariance)
    motions.push_back((row.t_ns - 1'000'000'000) / 100'000'000);
  EXPECT_THAT(motions, ElementsAre(1, 2, 5));
}

TEST(Outputs, InitialisingFramesHaveNoPose) {
  Recorder recorder;
  for (int i = 0; i < 4; ++i) {
    FramePose pose = SomePose(i, i < 3 ? TrackingState::kInitialising : TrackingState::kTracking);
    if (i == 2) pose.keyframe_id = 0;
    recorder.AddPose(pose);
  }
  const plslam::Run run = RunOf(recorder, Map(), Eigen::Quaterniond::Identity());
  EXPECT_THAT(FramesOf(*run.trajectory), ElementsAre(2, 3));
  EXPECT_THAT(FramesOf(*run.live), ElementsAre(2, 3));
  EXPECT_EQ(run.covariance->size(), 2u);
}

double Difference(const TrajectoryPose& a, const TrajectoryPose& b) {
  EXPECT_EQ(a.t_ns, b.t_ns);
  return (a.T_a_b.matrix() - b.T_a_b.matrix()).norm();
}

TEST(Outputs, FolderHasTheRunOfTheRecording) {
  Recorder recorder;
  for (int i = 0; i < 4; ++i) {
    FramePose pose = SomePose(i, i == 2 ? TrackingState::kLost : TrackingState::kTracking);
    pose.T_w_odom = SE3::Exp((Vector6d() << 1, 2, 3, 0.3, 0.2, 0.1 * i).finished());
    pose.keyframe_id = i == 1 ? 0 : -1;
    if (i == 3) pose.stages_ms.emplace_back("a,b", 1.5);
    recorder.AddPose(pose);
    recorder.AddTruth(i, {pose.t_ns, pose.T_w_odom});
  }
  const ScratchFolder folder;
  WriteOutputs(folder.Path(""), recorder, Map(), Eigen::Quaterniond(0.8, 0.6, 0.0, 0.0));
  const plslam::Run read =
      ReadRun(folder.Path(""), run_content::kTrajectory | run_content::kLive | run_content::kKeyframes |
                                   run_content::kTruth | run_content::kCovariances | run_content::kFrames);
  const plslam::Run run = RunOf(recorder, Map(), Eigen::Quaterniond(0.8, 0.6, 0.0, 0.0));
  for (const auto member :
       {&plslam::Run::trajectory, &plslam::Run::live, &plslam::Run::keyframes, &plslam::Run::truth}) {
    ASSERT_EQ((read.*member)->size(), (run.*member)->size());
    for (size_t i = 0; i < (run.*member)->size(); ++i)
      EXPECT_LT(Difference((read.*member)->at(i), (run.*member)->at(i)), 2e-9) << "files have nine decimals";
  }
  for (const auto member : {&plslam::Run::covariance, &plslam::Run::motion_covariance}) {
    ASSERT_EQ((read.*member)->size(), (run.*member)->size());
    for (size_t i = 0; i < (run.*member)->size(); ++i)
      EXPECT_EQ((read.*member)->at(i).covariance, (run.*member)->at(i).covariance);
  }
  const FrameTable table = FrameTableOf(recorder);
  EXPECT_EQ(read.frames->columns, table.columns);
  ASSERT_EQ(read.frames->rows.size(), 4U);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(read.frames->rows[i].t_ns, table.rows[i].t_ns);
    EXPECT_EQ(read.frames->rows[i].values, table.rows[i].values);
  }
}

TEST(Outputs, PosesAreOfTheCalibratedLeftCamera) {
  const SE3 T_w_odom = SE3::Exp((Vector6d() << 1, 2, 3, 0.3, 0.2, 0.1).finished());
  const SE3 T_odom_c = SE3::Exp((Vector6d() << 4, 5, 6, -0.3, 0.2, 0.7).finished());
  const Eigen::Quaterniond q_l_c(Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, 2, 3).normalized()));
  Recorder recorder;
  FramePose pose = SomePose(0);
  pose.T_w_odom = T_w_odom;
  pose.T_odom_c = T_odom_c;
  recorder.AddPose(pose);
  const SE3 T_w_l = RunOf(recorder, Map(), q_l_c).trajectory->at(0).T_a_b;
  // A point of c, expressed in l, must be at the same position of the map.
  const Eigen::Vector3d p_c(0.5, -0.4, 8.0);
  EXPECT_LT((T_w_l * (q_l_c * p_c) - T_w_odom * (T_odom_c * p_c)).norm(), 1e-12);
}

TEST(Outputs, CovariancesAreOfTheCalibratedCamera) {
  const Eigen::Quaterniond q_l_c(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
  Recorder recorder;
  FramePose pose = SomePose(0);
  const Vector6d x_c = (Vector6d() << 1, 2, 3, 4, 5, 6).finished();
  pose.covariance = x_c * x_c.transpose();
  recorder.AddPose(pose);
  const Matrix6d covariance = RunOf(recorder, Map(), q_l_c).covariance->at(0).covariance;
  // T * Exp(x_c) * T_c_l == T * T_c_l * Exp(Ad(T_l_c) x_c).
  const Vector6d x_l = SE3(q_l_c, Eigen::Vector3d::Zero()).Adjoint() * x_c;
  EXPECT_LT((covariance - x_l * x_l.transpose()).norm(), 1e-4);
}

TEST(Outputs, TimesThatDoNotIncreaseAreLeftOut) {
  Recorder recorder;
  recorder.AddPose(SomePose(0));
  FramePose same_time = SomePose(1);
  same_time.t_ns = SomePose(0).t_ns;
  recorder.AddPose(same_time);
  recorder.AddPose(SomePose(2));
  recorder.AddTruth(0, {5, SE3()});
  recorder.AddTruth(1, {4, SE3()});
  const plslam::Run run = RunOf(recorder, Map(), Eigen::Quaterniond::Identity());
  EXPECT_THAT(FramesOf(*run.trajectory), ElementsAre(0, 2));
  EXPECT_EQ(run.truth->size(), 1u);
}

TEST(Outputs, MotionIntoANewSessionHasNoCovariance) {
  Recorder recorder;
  recorder.AddPose(SomePose(0));
  FramePose pose = SomePose(1);
  pose.session = 8;
  recorder.AddPose(pose);
  EXPECT_TRUE(RunOf(recorder, Map(), Eigen::Quaterniond::Identity()).motion_covariance->empty());
}

TEST(Outputs, AllFilesAreWrittenAndReadable) {
  const ScratchFolder folder;
  const std::string out = folder.Path("a/b");
  Recorder recorder;
  for (int i = 0; i < 5; ++i) {
    recorder.AddPose(SomePose(i));
    recorder.AddTruth(i, {SomePose(i).t_ns, SE3()});
  }
  PrepareOutputFolder(out);
  EXPECT_THAT(WriteOutputs(out, recorder, Map(), Eigen::Quaterniond::Identity()), testing::IsEmpty());
  for (const char* name : {"trajectory.tum", "trajectory.kitti", "trajectory.euroc", "groundtruth.tum"}) {
    EXPECT_EQ(ReadTrajectory(out + "/" + name).size(), 5u) << name;
  }
  EXPECT_EQ(ReadTrajectory(out + "/keyframes.tum").size(), 0u);
  EXPECT_EQ(ReadPoseCovariances(out + "/covariance.txt").size(), 5u);
  EXPECT_EQ(ReadPoseCovariances(out + "/motion_covariance.txt").size(), 4u);
  for (const auto& entry : std::filesystem::directory_iterator(out)) {
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  }
}

TEST(Outputs, UnconnectedSessionsAreKeptApart) {
  const ScratchFolder folder;
  Recorder recorder;
  Map map;
  for (int i = 0; i < 6; ++i) {
    FramePose pose = SomePose(i);
    pose.session = i < 4 ? 7 : 8;
    pose.keyframe_id = i;
    recorder.AddPose(pose);
    MapKeyframe keyframe;
    keyframe.name.number = i;
    keyframe.frame_id = FrameId(i);
    keyframe.id = KeyframeId(keyframe.name.number);
    keyframe.name.session = pose.session;
    keyframe.t_ns = pose.t_ns;
    map.Put(keyframe);
  }
  WriteOutputs(folder.Path(""), recorder, map, Eigen::Quaterniond::Identity());
  EXPECT_THAT(FramesOf(ReadTrajectory(folder.Path("trajectory.tum"))), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(FramesOf(ReadTrajectory(folder.Path("keyframes.tum"))), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(FramesOf(ReadTrajectory(folder.Path("part2/trajectory.tum"))), ElementsAre(4, 5));
  EXPECT_THAT(FramesOf(ReadTrajectory(folder.Path("part2/keyframes.tum"))), ElementsAre(4, 5));
  EXPECT_TRUE(std::filesystem::exists(folder.Path("part2/map.ply")));
  LoopEdge loop;
  loop.old_keyframe_id = 0;
  loop.keyframe_id = 5;
  map.Add(loop);
  WriteOutputs(folder.Path(""), recorder, map, Eigen::Quaterniond::Identity());
  EXPECT_EQ(ReadTrajectory(folder.Path("trajectory.tum")).size(), 6U) << "recognised later";
  EXPECT_FALSE(std::filesystem::exists(folder.Path("part2")));
}

TEST(Outputs, EmptyRunWritesEmptyFilesAndNoGroundTruth) {
  const ScratchFolder folder;
  WriteOutputs(folder.Path(""), {}, {}, Eigen::Quaterniond::Identity());
  EXPECT_TRUE(ReadTrajectory(folder.Path("trajectory.tum")).empty());
  EXPECT_FALSE(std::filesystem::exists(folder.Path("groundtruth.tum")));
}

TEST(Outputs, TableHasLostFramesAndSafeColumnNames) {
  Recorder recorder;
  recorder.AddPose(SomePose(0));
  FramePose lost = SomePose(1, TrackingState::kLost);
  lost.stages_ms = {{"a,\"b\n", 1.0}};
  lost.keyframe_id = 12;
  lost.entropy_ratio = 0.875;
  recorder.AddPose(lost);
  EXPECT_EQ(TextOf([&](const AppendText& to) { WritePosesCsv(recorder, to); }),
            "frame_id,t_s,state,n_points,n_lines,n_tracked_points,n_tracked_lines,keyframe_id,entropy_ratio,"
            "skipped_frames,n_moving,anchored,orb_ms,pose_ms,a__b__ms\n"
            "0,1.000000000,tracking,800,120,312,84,-1,0,0,0,1,4.5000,0.2500,\n"
            "1,1.100000000,lost,800,120,312,84,12,0.875,0,0,1,,,1.0000\n");
}

TEST(Outputs, BodiesHaveTheirPositionsInTheMap) {
  Recorder recorder;
  FramePose pose = SomePose(0);
  pose.T_w_odom = SE3(Eigen::Quaterniond::Identity(), {10.0, 0.0, 0.0});
  pose.T_odom_c = SE3(Eigen::Quaterniond::Identity(), {0.0, 2.0, 0.0});
  recorder.AddPose(pose);
  recorder.AddPose(SomePose(1, TrackingState::kLost));
  recorder.AddPose(SomePose(3));
  const SE3 T_c_body(Eigen::Quaterniond::Identity(), {0.0, 0.0, 5.0});
  EXPECT_TRUE(recorder.AddBodies(0, {pose.session, {{3, T_c_body, 40}}}));
  EXPECT_TRUE(recorder.AddBodies(1, {pose.session, {{3, T_c_body, 41}}})) << "a lost frame has no place in the map";
  EXPECT_TRUE(recorder.AddBodies(7, {pose.session, {{3, T_c_body, 42}}})) << "its pose has not come";
  EXPECT_TRUE(recorder.AddBodies(3, {SessionId(pose.session.value + 1), {{3, T_c_body, 43}}}))
      << "its pose is of another session";
  EXPECT_FALSE(recorder.AddBodies(2, {pose.session, {{-1, T_c_body, 40}}}));
  EXPECT_EQ(TextOf([&](const AppendText& to) { WriteBodiesCsv(recorder, Map(), to); }),
            fmt::format("session,body,frame_id,t_s,x_m,y_m,z_m,qx,qy,qz,qw,n_features\n"
                        "{},3,0,1.000000000,10.000000,2.000000,5.000000,0.000000000,0.000000000,0.000000000,"
                        "1.000000000,40\n",
                        pose.session));
}

TEST(Outputs, ImpossibleFolderIsNamed) {
  const ScratchFolder folder;
  const std::string file = folder.Write("file", "");
  EXPECT_THAT([&] { PrepareOutputFolder(file + "/out"); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("file/out: the folder cannot be created: ")));
  EXPECT_THAT([&] { PrepareOutputFolder("/proc/plslam"); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("/proc/plslam: the folder cannot be ")));
}

TEST(Outputs, FullDiskIsReportedAndLeavesNoPartialFile) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const ScratchFolder folder;
  std::filesystem::create_symlink("/dev/full", folder.Path("trajectory.tum.part"));
  Recorder recorder;
  recorder.AddPose(SomePose(0));
  EXPECT_THAT(WriteOutputs(folder.Path(""), recorder, Map(), Eigen::Quaterniond::Identity()),
              testing::ElementsAre(HasSubstr("trajectory.tum: cannot be written: No space left on device")));
  EXPECT_FALSE(std::filesystem::exists(folder.Path("trajectory.tum")));
  for (const char* name : {"trajectory.kitti", "keyframes.euroc", "covariance.txt", "poses.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.Path(name))) << name << ": the others are written";
  }
}

}  // namespace
}  // namespace plslam
