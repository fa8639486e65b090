// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/trajectories/pose_covariance.h"
#include "plslam_version.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"
#include "tests/unit/evaluate/pairs.h"

namespace plslam::evaluate {
namespace {

using test::ShellResult;
using testing::HasSubstr;
using testing::Not;

ShellResult Evaluate(const ScratchFolder& folder, const std::string& arguments) {
  return test::Shell(folder, (test::BinaryFolder() / "evaluate").string() + " " + arguments);
}

TEST(EvaluateProgram, ComparesDifferentFormatsAndWritesAllOutputs) {
  const ScratchFolder folder;
  const Trajectory truth = SomePath(50);
  const Trajectory estimate = WithDrift(truth, Translation(0, 0, 0.01));
  WriteTrajectory(folder.Path("truth.csv"), TrajectoryFormat::kEuroc, truth);
  WriteTrajectory(folder.Path("estimate.tum"), TrajectoryFormat::kTum, estimate);
  WriteTrajectory(folder.Path("keyframes.tum"), TrajectoryFormat::kTum, {estimate[0], estimate[20], estimate[40]});
  std::vector<PoseCovariance> motions;
  for (const TrajectoryPose& pose : estimate) motions.push_back({pose.t_ns, 1e-4 * Matrix6d::Identity()});
  WritePoseCovariances(folder.Path("motion.txt"), motions);
  const ShellResult run = Evaluate(
      folder, folder.Path("estimate.tum") + " --truth " + folder.Path("truth.csv") + " --keyframes " +
                  folder.Path("keyframes.tum") + " --motion-covariance " + folder.Path("motion.txt") +
                  " --delta 1f 2s --align first --json " + folder.Path("a.json") + " --plot " + folder.Path("a.png"));
  EXPECT_EQ(run.exit_code, 0) << run.error;
  EXPECT_THAT(run.out, HasSubstr("50 associated; coverage 100.0 %"));
  EXPECT_THAT(run.out, HasSubstr("RPE 2s translation [m]"));
  const auto json = nlohmann::json::parse(ReadText(folder.Path("a.json")));
  EXPECT_NEAR(json["rpe"][0]["translation_m"]["rmse"].get<double>(), 0.01, 1e-6);
  EXPECT_EQ(json["keyframes"]["motions"], 2);
  EXPECT_NEAR(json["nees_motion"]["mean"].get<double>(), 1.0, 1e-3);
  EXPECT_THAT(ReadText(folder.Path("a.png")).substr(1, 3), "PNG");
}

TEST(EvaluateProgram, BadRowsOfTheTruthAreNoted) {
  const ScratchFolder folder;
  const Trajectory truth = SomePath(50);
  WriteTrajectory(folder.Path("estimate.tum"), TrajectoryFormat::kTum, truth);
  WriteTrajectory(folder.Path("truth.tum"), TrajectoryFormat::kTum, truth);
  const std::string text = ReadText(folder.Path("truth.tum"));
  folder.Write("truth.tum", text + text.substr(text.rfind('\n', text.size() - 2) + 1));
  const std::string arguments = folder.Path("estimate.tum") + " --truth " + folder.Path("truth.tum");
  const ShellResult run = Evaluate(folder, arguments);
  EXPECT_EQ(run.exit_code, 0) << run.error;
  EXPECT_THAT(run.error, HasSubstr("truth.tum:51: time "));
  EXPECT_THAT(run.error, HasSubstr("1 of 51 rows is skipped"));
  folder.Write("truth.tum", "1 nan nan nan nan nan nan nan\n2 nan nan nan nan nan nan nan\n");
  const ShellResult none = Evaluate(folder, arguments);
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.error, HasSubstr("2 of 2 rows are skipped"));
}

TEST(EvaluateProgram, ErrorsAreOneSentenceAndExitCodeOne) {
  const ScratchFolder folder;
  const std::string good = folder.Write("good", "1 0 0 0 0 0 0 1\n");
  const std::string far = folder.Write("far", "1 0 0 0 0 0 0 1\n2 1e200 0 0 0 0 0 1\n");
  const std::string late = folder.Write("late", "9 0 0 0 0 0 0 1\n");
  const std::string kitti = folder.Write("a.kitti", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  const std::string longer = folder.Write("b.kitti", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n");
  const std::string bad = folder.Write("bad", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 x\n");
  const std::vector<std::pair<std::string, std::string>> cases{
      {bad + " --truth " + good, "bad:2: 'x' is not a finite number"},
      {good + " --truth " + folder.Path("none"), "none: cannot be read: No such file or directory"},
      {far + " --truth " + good, "far:2: the position is 1e+200 m from the origin, more than 1e+09 m"},
      {good + " --truth " + late, "no pose of the estimate is within 0.02 s"},
      {good + " --truth " + good + " --delta 1x", "'1x' is not an interval"},
      {good + " --truth " + good + " --json " + folder.Path("no/a.json"), "a.json: cannot be created"},
      {good + " --truth " + good + " --plot " + folder.Path("no/a.pdf"), "a.pdf: cannot be created"},
      {good + " --truth " + good + " --plot a.jpg", "a.jpg: a drawing is written as .svg, .pdf or .png"},
      {good + " --truth " + good + " --align rigid", "rigid"},
      {good + " --truth " + good + " --truth-format kitti",
       "good:1: 8 numbers, but a row of the KITTI format has 12"},
      {kitti + " --truth " + good,
       "a.kitti: has no times because it is in KITTI format, but " + good + " has: give --times"},
      {good + " --truth " + kitti, "a.kitti: has no times"},
      {kitti + " --truth " + longer, "a.kitti has 1 poses and " + longer + " has 2, without times"},
      {kitti + " --truth " + longer, "give the estimate with its times (trajectory.tum of a run), and --times"},
      {good, "evaluate: error: --truth is required"}};
  for (const auto& [arguments, sentence] : cases) {
    const ShellResult run = Evaluate(folder, arguments);
    EXPECT_EQ(run.exit_code, 1) << arguments;
    EXPECT_THAT(run.error, HasSubstr(sentence));
  }
}

TEST(EvaluateProgram, KittiFilesTakeTheirTimesFromTheTimesFile) {
  PLSLAM_REQUIRE_DATA(data, "trajectories/kitti");
  const ScratchFolder folder;
  const std::string poses = (data / "04.txt").string();
  const std::string times = (data / "04_times.txt").string();
  const ShellResult run = Evaluate(folder, poses + " --truth " + poses + " --times " + times + " --align sim3");
  EXPECT_EQ(run.exit_code, 0) << run.error;
  EXPECT_THAT(run.out, HasSubstr("true path   393.6"));
  EXPECT_THAT(run.out, HasSubstr("scale 1.000000"));
}

TEST(EvaluateProgram, ComparisonSkipsOtherFiles) {
  const ScratchFolder folder;
  const auto add = [&](const std::string& name, const std::string& summary) {
    std::filesystem::create_directories(folder.Path(name));
    folder.Write(name + "/summary.json", summary);
  };
  add("run", R"({"dataset": "d", "completed": true, "frames": 40, "tracked_frames": 10, "all_frames": 50})");
  add("strange", R"({"name": "something else"})");
  add("broken", "{");
  folder.Write("room.plmap", "a map");
  std::filesystem::create_directories(folder.Path("first/logs"));
  const ShellResult all = Evaluate(folder, "compare " + folder.Path("") + "/*");
  EXPECT_EQ(all.exit_code, 0) << all.error;
  EXPECT_THAT(all.out, HasSubstr("1 run"));
  EXPECT_THAT(all.out, HasSubstr("20.0")) << "per cent tracked";
  EXPECT_THAT(all.error, HasSubstr("that are not runs: "));
  for (const char* name : {"strange", "broken", "room.plmap", "first"}) EXPECT_THAT(all.error, HasSubstr(name));
  const ShellResult alone = Evaluate(folder, "compare " + folder.Path("run"));
  EXPECT_THAT(alone.error, Not(HasSubstr("skipped")));
  const ShellResult none = Evaluate(folder, "compare " + folder.Path("first") + " " + folder.Path("room.plmap"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.error, HasSubstr("no run to compare"));
  const ShellResult missing = Evaluate(folder, "compare " + folder.Path("run") + " " + folder.Path("mistyped"));
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.error, HasSubstr("mistyped: does not exist"));
}

TEST(EvaluateProgram, HelpAndVersion) {
  const ScratchFolder folder;
  EXPECT_EQ(Evaluate(folder, "--help").exit_code, 0);
  EXPECT_THAT(Evaluate(folder, "--version").out, HasSubstr(PLSLAM_VERSION));
}

}  // namespace
}  // namespace plslam::evaluate
