#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <map>
#include <sstream>

#include "core/io/trajectory.h"
#include "player/open_dataset.h"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/recorded_run.h"
#include "tests/integration/whole_run.h"

namespace plslam {
namespace {

using test::ChosenFrame;
using test::ReadRecordedRun;
using test::RecordedRun;
using test::WholeRun;

/// Twice round the room.
const std::string kTwoLaps = "synthetic:room?size=376x240&loops=2&speed=2";

Trajectory ReadPath(const WholeRun& run, const std::string& file) {
  return ReadTrajectory((run.out() / file).string(), TrajectoryFormat::kTum);
}

/// Of frames at the same time: how many, and how many within 5 cm and a degree of each other.
struct Agreement {
  int common = 0;
  int close = 0;
};

Agreement Compare(const Trajectory& a, const Trajectory& b) {
  std::map<int64_t, SE3> by_time;
  for (const TrajectoryPose& pose : a) by_time[pose.t_ns] = pose.T_a_b;
  Agreement agreement;
  for (const TrajectoryPose& pose : b) {
    const auto other = by_time.find(pose.t_ns);
    if (other == by_time.end()) continue;
    ++agreement.common;
    const Vector6d difference = (other->second.Inverse() * pose.T_a_b).Log();
    if (difference.head<3>().norm() < 0.05 && difference.tail<3>().norm() < 0.01745) ++agreement.close;
  }
  return agreement;
}

TEST(Loops, AreClosedAndTheSameAtEveryRun) {
  WholeRun first, second;
  ASSERT_EQ(first.Run({"run", kTwoLaps, "--record", first.log()}), 0) << first.Logs();
  ASSERT_EQ(second.Run({"run", kTwoLaps, "--record", second.log()}), 0) << second.Logs();
  const nlohmann::json summary = first.Summary();
  EXPECT_GE(summary["loops"], 1) << first.Logs();
  EXPECT_EQ(summary["tracked_frames"], summary["frames"]);
  EXPECT_LT(summary["accuracy"]["ate_m"], 0.02) << summary["accuracy"].dump(1);
  EXPECT_EQ(summary["loop_closing"]["keyframes"], summary["keyframes"]) << "each is judged once";
  const RecordedRun a = ReadRecordedRun(first.log()), b = ReadRecordedRun(second.log());
  EXPECT_EQ(a.Gaps("LOOP_CLOSURE"), 0);
  EXPECT_EQ(a.map_totals.loops, summary["loops"]);
  EXPECT_EQ(a.poses, b.poses);
  EXPECT_TRUE(a.map_bytes == b.map_bytes);
  EXPECT_EQ(first.Read("trajectory.tum"), second.Read("trajectory.tum"));
  EXPECT_TRUE(first.Read("map.ply") == second.Read("map.ply"));
}

TEST(Loops, KilledLoopProcessIsStartedAgainAndTheRunGoesOn) {
  WholeRun run;
  run.Start({"run", kTwoLaps, "--record", run.log()});
  const auto under_way = [&] {
    return std::filesystem::exists(run.log()) && std::filesystem::file_size(run.log()) > 20'000'000;
  };
  ASSERT_TRUE(WholeRun::WaitFor(under_way)) << run.Logs();
  const pid_t loop = run.PidOf("loop_process");
  ASSERT_GT(loop, 0);
  ASSERT_EQ(kill(loop, SIGKILL), 0);
  ASSERT_EQ(run.Wait(), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["processes"]["loop"]["restarts"], 1);
  EXPECT_EQ(summary["tracked_frames"], summary["frames"]);
  EXPECT_LT(summary["accuracy"]["ate_m"], 0.02) << summary["accuracy"].dump(1);
}

TEST(SavedMap, IsLocalisedInWithoutChangingIt) {
  WholeRun first, second, third;
  const std::string map = (first.folder() / "room.plmap").string();
  ASSERT_EQ(first.Run({"run", "synthetic:room?size=376x240&speed=2", "--save-map", map}), 0) << first.Logs();
  ASSERT_TRUE(std::filesystem::exists(map)) << first.Logs();
  const std::string again = (second.folder() / "again.plmap").string();
  ASSERT_EQ(second.Run(
                {"run", "synthetic:room?size=376x240&speed=2", "--map", map, "--localise-only", "--save-map", again}),
            0)
      << second.Logs();
  const Agreement agreement = Compare(ReadPath(first, "trajectory.tum"), ReadPath(second, "trajectory.tum"));
  const int frames = first.Summary()["frames"];
  EXPECT_GE(agreement.common, 99 * frames / 100) << "of " << frames;
  EXPECT_GE(agreement.close, 99 * agreement.common / 100) << "of " << agreement.common;
  EXPECT_EQ(second.Summary()["map"]["keyframes"], first.Summary()["map"]["keyframes"]);
  EXPECT_EQ(std::filesystem::file_size(again), std::filesystem::file_size(map));

  // A second lap from elsewhere on goes on in the same map: it is one with what was there.
  ASSERT_EQ(third.Run({"run", "synthetic:room?size=376x240&speed=2", "--map", map, "--start", "40"}), 0)
      << third.Logs();
  EXPECT_GT(third.Summary()["map"]["keyframes"], first.Summary()["map"]["keyframes"]);
  const Agreement joined = Compare(ReadPath(first, "trajectory.tum"), ReadPath(third, "trajectory.tum"));
  EXPECT_GT(joined.common, 0);
  EXPECT_GE(joined.close, 95 * joined.common / 100) << "of " << joined.common << '\n' << third.Logs();
}

TEST(SavedMap, OfAnotherCameraOrForeignBytesIsRefusedInOneSentence) {
  WholeRun first, second, third;
  const std::string map = (first.folder() / "room.plmap").string();
  ASSERT_EQ(first.Run({"run", "synthetic:room?size=376x240&frames=20", "--save-map", map}), 0) << first.Logs();
  EXPECT_NE(second.Run({"run", "synthetic:room?size=320x240&frames=20", "--map", map, "--max-restarts", "0"}), 0);
  EXPECT_THAT(second.Logs(), testing::HasSubstr("another camera"));
  const std::string foreign = (third.folder() / "foreign.plmap").string();
  std::filesystem::copy_file(second.folder() / "plslam.log", foreign);
  EXPECT_NE(third.Run({"run", "synthetic:room?size=376x240&frames=20", "--map", foreign, "--max-restarts", "0"}), 0);
  EXPECT_THAT(third.Logs(), testing::HasSubstr("foreign.plmap"));
}

TEST(Relocalisation, CameraCarriedWithItsLensCoveredIsFoundAgain) {
  WholeRun run;
  const auto room = OpenDataset("synthetic:room?size=376x240&speed=2", "");
  // Most of a lap, then covered while it is carried back to where it was long before.
  std::vector<ChosenFrame> frames;
  for (int i = 0; i < 110; ++i) frames.push_back({i, false});
  for (int i = 0; i < 15; ++i) frames.push_back({110, true});
  for (int i = 30; i < 60; ++i) frames.push_back({i, false});
  WriteImageFolder(*room, frames, run.folder() / "carried");
  ASSERT_EQ(run.Run({"run", (run.folder() / "carried").string()}), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_GE(summary["loop_closing"]["relocalisations"]["found"], 1) << summary.dump(1);
  EXPECT_GE(summary["tracked_frames"], 110 + 30 - 3);
  EXPECT_LT(summary["accuracy"]["ate_m"], 0.02) << summary["accuracy"].dump(1);
}

}  // namespace
}  // namespace plslam
