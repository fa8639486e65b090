// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "core/datasets/open_dataset.h"
#include "core/io/trajectories/trajectory.h"
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

/// Numbers of frames at the same time, and of those within 5 cm and a degree of each other.
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

/// Returns the error of each published pose against the truth, by its frame; `shown` frame by frame, in a map that
/// began at frame 0 of the dataset.
std::map<int, double> ErrorsInMap(const WholeRun& run, const Dataset& dataset,
                                  const std::vector<ChosenFrame>& shown) {
  constexpr double kFrame_ns = 5e7;
  std::map<int, double> errors_m;
  const SE3 T_w_world = dataset.GroundTruth(0)->Inverse();
  for (const TrajectoryPose& pose : ReadPath(run, "trajectory_live.tum")) {
    const auto frame = static_cast<int>(std::lround(static_cast<double>(pose.t_ns) / kFrame_ns)) - 1;
    const SE3 truth = T_w_world * *dataset.GroundTruth(shown.at(static_cast<size_t>(frame)).index);
    errors_m[frame] = (pose.T_a_b.translation() - truth.translation()).norm();
  }
  return errors_m;
}

TEST(Loops, AreClosedAndTheSameAtEveryRun) {
  WholeRun first, second;
  ASSERT_EQ(first.Run({"run", kTwoLaps, "--record", first.log()}), 0) << first.Logs();
  ASSERT_EQ(second.Run({"run", kTwoLaps, "--record", second.log()}), 0) << second.Logs();
  const nlohmann::json summary = first.Summary();
  EXPECT_GE(summary["loops"], 1) << first.Logs();
  EXPECT_EQ(summary["tracked_frames"], summary["frames"]);
  EXPECT_LT(summary["accuracy"]["ate_m"], 0.02) << summary["accuracy"].dump(1);
  EXPECT_EQ(summary["loop_closing"]["keyframes"], summary["keyframes"]) << "each is checked once";
  const RecordedRun a = ReadRecordedRun(first.log()), b = ReadRecordedRun(second.log());
  EXPECT_EQ(a.Gaps("LOOP_CLOSURE"), 0);
  EXPECT_EQ(a.map_totals.loops, summary["loops"]);
  ASSERT_EQ(a.poses.size(), summary["frames"]);
  EXPECT_EQ(a.poses, b.poses);
  EXPECT_EQ(a.keyframes, b.keyframes);
  EXPECT_TRUE(a.map_bytes == b.map_bytes);
  for (const char* file : {"trajectory.tum", "trajectory_live.tum", "keyframes.tum", "map.ply"}) {
    EXPECT_TRUE(first.Read(file) == second.Read(file)) << file;
  }
}

TEST(SavedMap, LocaliseOnlyDoesNotChangeTheMap) {
  WholeRun first, second;
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

  // A second lap that starts elsewhere continues the same map, and is joined with its keyframes. A copy of the bookcase
  // in frames 40 and 42 stands in the room at the end of the first lap.
  for (const char* start : {"40", "42"}) {
    WholeRun later;
    ASSERT_EQ(later.Run({"run", "synthetic:room?size=376x240&speed=2", "--map", map, "--start", start}), 0)
        << later.Logs();
    EXPECT_GT(later.Summary()["map"]["keyframes"], first.Summary()["map"]["keyframes"]);
    const Agreement joined = Compare(ReadPath(first, "trajectory.tum"), ReadPath(later, "trajectory.tum"));
    EXPECT_GT(joined.common, 0);
    EXPECT_GE(joined.close, 95 * joined.common / 100) << "of " << joined.common << '\n' << later.Logs();
  }
}

/// A map of the first 60 frames of a lap of 150.
class PartOfTheRoom : public testing::Test {
 protected:
  PartOfTheRoom() { exit_code_ = first_.Run({"run", kRoom + "&frames=60", "--save-map", map()}); }
  std::string map() const { return (first_.folder() / "room.plmap").string(); }
  /// Localises these frames in the map.
  std::map<int, double> Localise(const std::vector<ChosenFrame>& frames) {
    const auto room = OpenDataset(kRoom, "");
    WriteImageFolder(*room, frames, run_.folder() / "frames");
    EXPECT_EQ(exit_code_, 0) << first_.Logs();
    EXPECT_EQ(run_.Run({"run", (run_.folder() / "frames").string(), "--map", map(), "--localise-only"}), 0)
        << run_.Logs();
    return ErrorsInMap(run_, *room, frames);
  }

  const std::string kRoom = "synthetic:room?size=376x240&speed=2";
  WholeRun first_, run_;
  int exit_code_ = -1;
};

TEST_F(PartOfTheRoom, CameraCarriedOutOfTheMapAndBack) {
  std::vector<ChosenFrame> frames;
  for (int i = 0; i < 30; ++i) frames.push_back({i, false});
  for (int i = 0; i < 10; ++i) frames.push_back({30, true});
  for (int i = 100; i < 150; ++i) frames.push_back({i, false});
  const auto back = static_cast<int>(frames.size());
  for (int i = 0; i < 60; ++i) frames.push_back({i, false});
  const std::map<int, double> errors_m = Localise(frames);
  int n_back = 0;
  for (const auto& [frame, error_m] : errors_m) {
    EXPECT_LT(error_m, 0.1) << "frame " << frame;
    if (frame >= back) ++n_back;
  }
  EXPECT_GE(n_back, 57) << run_.Logs();
}

TEST_F(PartOfTheRoom, IsUsedAgainWhenBackInView) {
  // Once round the room, through unmapped parts, and again.
  const int lap = OpenDataset(kRoom, "")->size();
  std::vector<ChosenFrame> frames;
  for (int i = 0; i < 2 * lap; ++i) frames.push_back({i % lap, false});
  const std::map<int, double> errors_m = Localise(frames);
  double sum_m = 0.0;
  for (int i = lap + 20; i < lap + 50; ++i) sum_m += errors_m.at(i) / 30.0;
  EXPECT_LT(sum_m, 0.01) << "first lap: " << errors_m.at(30);
}

TEST(SavedMap, ForeignBytesAreRefused) {
  WholeRun run;
  const std::string foreign = (run.folder() / "foreign.plmap").string();
  std::ofstream(foreign) << "no map\n";
  EXPECT_NE(run.Run({"run", "synthetic:room?size=376x240&frames=20", "--map", foreign, "--max-restarts", "0"}), 0);
  EXPECT_THAT(run.Logs(), testing::HasSubstr("foreign.plmap"));
  EXPECT_FALSE(std::filesystem::exists(run.out())) << "nothing was begun";
}

/// Returns the error of each published pose against the truth, in a map that began at frame 0 of the dataset.
std::vector<double> LiveErrors_m(const WholeRun& run, const Dataset& dataset) {
  std::map<int64_t, SE3> truth;
  for (int i = 0; i < dataset.size(); ++i) truth[dataset.t_ns(i)] = *dataset.GroundTruth(i);
  const SE3 T_w_world = truth.begin()->second.Inverse();
  std::vector<double> errors_m;
  for (const TrajectoryPose& pose : ReadPath(run, "trajectory_live.tum"))
    errors_m.push_back((pose.T_a_b.translation() - (T_w_world * truth.at(pose.t_ns)).translation()).norm());
  return errors_m;
}

// The other camera has another lens, size and baseline; afterwards the first camera uses the map of both.
TEST(SavedMap, MapOfAnotherCameraIsUsedAndExtended) {
  const std::string room = "synthetic:room?size=376x240&speed=2&frames=90";
  const std::string other_room = "synthetic:room?size=560x380&fov=66&baseline=0.2&speed=2&frames=90";
  WholeRun first, localised, gone_on, again;
  const std::string map = (first.folder() / "room.plmap").string();
  const std::string of_both = (gone_on.folder() / "room.plmap").string();
  ASSERT_EQ(first.Run({"run", room, "--save-map", map}), 0) << first.Logs();
  const auto other = OpenDataset(other_room, "");

  ASSERT_EQ(localised.Run({"run", other_room, "--map", map, "--localise-only"}), 0) << localised.Logs();
  EXPECT_EQ(localised.Summary()["map"]["keyframes"], first.Summary()["map"]["keyframes"]);
  const std::vector<double> errors_m = LiveErrors_m(localised, *other);
  const auto n_near = std::count_if(errors_m.begin(), errors_m.end(), [](double error_m) { return error_m < 0.03; });
  EXPECT_GE(n_near, 0.95 * other->size()) << localised.Summary().dump(1);

  ASSERT_EQ(gone_on.Run({"run", other_room, "--map", map, "--save-map", of_both}), 0) << gone_on.Logs();
  EXPECT_LT(std::ranges::max(LiveErrors_m(gone_on, *other)), 0.03);
  EXPECT_GT(gone_on.Summary()["map"]["keyframes"], first.Summary()["map"]["keyframes"]);

  ASSERT_EQ(again.Run({"run", room, "--map", of_both, "--localise-only"}), 0) << again.Logs();
  EXPECT_GE(again.Summary()["tracked_frames"], again.Summary()["frames"].get<int>() - 2) << "until it is recognised";
  EXPECT_LT(again.Summary()["accuracy"]["ate_m"], 0.02) << again.Summary().dump(1);
}

TEST(Relocalisation, CameraCarriedWithItsLensCovered) {
  WholeRun run;
  const auto room = OpenDataset("synthetic:room?size=376x240&speed=2", "");
  // Most of a lap, then covered while it is carried back to a much earlier position.
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
