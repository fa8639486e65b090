// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/export_run.h"

#include <gmock/gmock.h>

#include "core/io/maps/map_file.h"
#include "core/io/trajectories/trajectory.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"
#include "tests/unit/export/small_map.h"
#include "tools/pose_graph/export.h"
#include "tools/pose_graph/g2o.h"

namespace plslam::exports {
namespace {

using testing::HasSubstr;

std::string ErrorOf(const ExportRequest& request) {
  try {
    ExportRun(request);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "none";
}

std::vector<std::string> NamesOf(const std::vector<ExportedFile>& files) {
  std::vector<std::string> names;
  for (const ExportedFile& file : files) names.push_back(std::filesystem::path(file.path).filename());
  return names;
}

TEST(ExportRun, AMapGivesAllFormats) {
  const ScratchFolder folder;
  WriteMapFile(folder.Path("a.plmap"), test::SmallStoredMap());
  const auto files = ExportRun({folder.Path("a.plmap"), folder.Path("out"), {}, ""});
  EXPECT_THAT(NamesOf(files), testing::ElementsAre("map.ply", "map.obj", "sparse", "text", "pose_graph.g2o",
                                                   "keyframes.tum", "keyframes.kitti", "keyframes_times.txt",
                                                   "keyframes.euroc", "run.mcap", "foxglove_layout.json"));
  for (const ExportedFile& file : files) EXPECT_TRUE(std::filesystem::exists(file.path)) << file.path;
  const pose_graph::G2oFile graph = pose_graph::ReadG2o(folder.Path("out/pose_graph.g2o"));
  EXPECT_EQ(std::get<pose_graph::G2oGraph<SE3>>(graph.content).ids.size(), 3U);
  const Trajectory keyframes =
      ReadTrajectory(folder.Path("out/keyframes.kitti"), folder.Path("out/keyframes_times.txt"));
  ASSERT_EQ(keyframes.size(), 3U);
  EXPECT_EQ(keyframes[2].t_ns, 2'000'000'005);
  EXPECT_NEAR(keyframes[2].T_a_b.translation().z(), 0.8, 1e-9);
}

TEST(ExportRun, AFolderWithoutMapGivesItsTrajectoryOnly) {
  const ScratchFolder folder;
  WriteTrajectory(folder.Path("trajectory.tum"), TrajectoryFormat::kTum, {{7, SE3()}, {8, SE3()}});
  const std::string out = folder.Path("to");
  EXPECT_THAT(NamesOf(ExportRun({folder.Path(""), out, {}, ""})),
              testing::ElementsAre("trajectory.tum", "trajectory.kitti", "trajectory_times.txt", "trajectory.euroc",
                                   "run.mcap", "foxglove_layout.json", "left out"));
  EXPECT_THAT(ErrorOf({folder.Path(""), out, {"ply"}, ""}), HasSubstr("ply needs a map: plslam run --save-map"));
}

TEST(ExportRun, MissingInputIsReported) {
  const ScratchFolder folder;
  const std::string out = folder.Path("out");
  EXPECT_THAT(ErrorOf({folder.Path("none"), out, {}, ""}), HasSubstr("none: file or folder does not exist"));
  EXPECT_THAT(ErrorOf({folder.Path(""), out, {}, ""}), HasSubstr("has neither a map (.plmap) nor a trajectory.tum"));
  EXPECT_THAT(ErrorOf({folder.Write("bad.plmap", "PLSLAMAP"), out, {}, ""}), HasSubstr("bad.plmap"));
  EXPECT_EQ(ErrorOf({folder.Path(""), out, {"stl"}, ""}), "'stl' is not an export format");
  folder.Write("worse.plmap", "");
  EXPECT_THAT(ErrorOf({folder.Path(""), out, {}, ""}), HasSubstr("has 2 maps: give one of them"));
}

TEST(ExportRun, EachSessionHasAFileOfKeyframes) {
  const ScratchFolder folder;
  StoredMap stored = test::SmallStoredMap();
  MapKeyframe again = stored.map.keyframes().begin()->second;  // another robot's, at the same time
  again.id = 1000;
  again.name.session = 3;
  stored.map.Put(again);
  const auto sessions = pose_graph::TrajectoriesOf(stored.map);
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_EQ(sessions[0].suffix, "");
  EXPECT_EQ(sessions[0].keyframes.size(), 3U);
  EXPECT_EQ(sessions[1].suffix, "_s3");
  EXPECT_EQ(sessions[1].keyframes.size(), 1U);
}

TEST(ExportRun, UnconnectedPartsHaveTheirOwnFolders) {
  const ScratchFolder folder;
  StoredMap stored = test::SmallStoredMap();
  MapKeyframe elsewhere = stored.map.keyframes().begin()->second;
  elsewhere.id = stored.next_keyframe_id++;
  elsewhere.name.session = 3;
  elsewhere.previous_id = elsewhere.parent_id = -1;
  stored.map.Put(elsewhere);
  WriteMapFile(folder.Path("a.plmap"), stored);
  const auto files = ExportRun({folder.Path("a.plmap"), folder.Path("out"), {"ply", "tum"}, ""});
  EXPECT_THAT(NamesOf(files), testing::ElementsAre("map.ply", "keyframes.tum", "part2", "map.ply", "keyframes.tum"));
  EXPECT_EQ(ReadTrajectory(folder.Path("out/keyframes.tum")).size(), 3U);
  EXPECT_EQ(ReadTrajectory(folder.Path("out/part2/keyframes.tum")).size(), 1U);
}

TEST(ExportRun, ImagesOfAnotherCameraAreRefused) {
  const ScratchFolder folder;
  WriteMapFile(folder.Path("a.plmap"), test::SmallStoredMap());
  EXPECT_THAT(ErrorOf({folder.Path("a.plmap"), folder.Path("out"), {}, "synthetic:room?size=160x120&frames=3"}),
              HasSubstr("is not that of the map: f_px "));
}

TEST(ExportRun, ImagesOfAnotherTimeAreRefused) {
  const ScratchFolder folder;
  WriteTrajectory(folder.Path("trajectory.tum"), TrajectoryFormat::kTum, {{5'000'000'000'000, SE3()}});
  EXPECT_THAT(ErrorOf({folder.Path(""), folder.Path("out"), {"mcap"}, "synthetic:room?size=160x120&frames=3"}),
              HasSubstr("has no image from the time of the run"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path("out"))) << "nothing half written stays";
}

TEST(ExportRun, ADamagedTableOfFramesIsNamed) {
  const ScratchFolder folder;
  WriteTrajectory(folder.Path("trajectory.tum"), TrajectoryFormat::kTum, {{1'000'000'000, SE3()}});
  folder.Write("poses.csv", "frame_id,t_s,state\n0,1.0,tracking\n1,x,tracking\n");
  EXPECT_THAT(ErrorOf({folder.Path(""), folder.Path("out"), {"mcap"}, ""}), HasSubstr("poses.csv:3: "));
  folder.Write("poses.csv", "frame_id,t_s,state\n0,1.0\n");
  EXPECT_THAT(ErrorOf({folder.Path(""), folder.Path("out"), {"mcap"}, ""}),
              HasSubstr("poses.csv:2: does not have the columns of the first line"));
  WriteTrajectory(folder.Path("trajectory.tum"), TrajectoryFormat::kTum, {{-1'000'000'000, SE3()}});
  std::filesystem::remove(folder.Path("poses.csv"));
  EXPECT_THAT(ErrorOf({folder.Path(""), folder.Path("out"), {"mcap"}, ""}), HasSubstr("no times before 1970"));
}

TEST(ExportProgram, PrintsItsFilesAndErrors) {
  const ScratchFolder folder;
  WriteMapFile(folder.Path("a.plmap"), test::SmallStoredMap());
  const std::string plslam = (test::BinaryFolder() / "plslam").string() + " export " + folder.Path("");
  const auto good = test::Shell(folder, plslam + "/a.plmap --format obj tum");
  EXPECT_EQ(good.exit_code, 0) << good.error;
  EXPECT_THAT(good.out, HasSubstr("a_export/map.obj: 61 points, 4 lines, the path of 3 keyframes\n"));
  const auto bad = test::Shell(folder, plslam + "/a.plmap --format stl");
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_THAT(bad.error, HasSubstr("stl"));
  const auto none = test::Shell(folder, plslam + "/none.plmap");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.error, HasSubstr("none.plmap: file or folder does not exist"));
}

}  // namespace
}  // namespace plslam::exports
