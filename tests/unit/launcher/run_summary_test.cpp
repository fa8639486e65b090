// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tools/plslam/run_files.h"
#include "tools/plslam/yaml_to_json.h"

namespace plslam::launcher {
namespace {

using nlohmann::json;

RunStatistics TwoFrames() {
  RunStatistics statistics;
  for (int id = 0; id < 2; ++id) {
    FrameReport frame;
    frame.frame_id = id;
    frame.state = static_cast<TrackingState>(id);
    frame.keyframe_id = id == 0 ? 0 : -1;
    frame.stage_ms = {{"total", 10.0 + id}};
    frame.age_ms = 12.0 + id;
    statistics.AddFrame(frame);
  }
  statistics.AddLandmark(0, 3, true);
  return statistics;
}

TEST(RunSummary, JsonHasTheDocumentedKeys) {
  const RunStatistics statistics = TwoFrames();
  RunSummary summary;
  summary.dataset = "synthetic:room";
  summary.version = "1";
  summary.completed = true;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.accuracy = json{{"ate_m", 0.01}};
  summary.messages = {3, 2, 1};
  summary.processes = {{"vo", 0.5, 80.0, 1, 0, 0.4, 3.0}};
  summary.configurations["vo"] = "vo:\n  enabled: true\n  name: \"7\"\n  list: [1, 2.5]\n";
  const json result = SummaryToJson(summary);
  EXPECT_EQ(result["frames"], 2);
  EXPECT_EQ(result["tracked_frames"], 2);
  EXPECT_EQ(result["keyframes"], 1);
  EXPECT_EQ(result["landmarks"], (json{{"points", 0}, {"lines", 1}}));
  EXPECT_EQ(result["loops"], 0);
  EXPECT_EQ(result["accuracy"]["ate_m"], 0.01);
  EXPECT_EQ(result["messages"], (json{{"lost", 3}, {"repaired", 2}, {"rejected", 1}}));
  EXPECT_NEAR(result["stage_ms"]["total"]["median"].get<double>(), 10.0, 0.06);
  EXPECT_NEAR(result["stage_ms"]["total"]["p95"].get<double>(), 11.0, 0.06);
  EXPECT_NEAR(result["pose_age_ms"]["median"].get<double>(), 12.0, 0.06);
  EXPECT_NEAR(result["pose_age_ms"]["p99"].get<double>(), 13.0, 0.07);
  EXPECT_EQ(result["processes"]["vo"]["cpu_ms_per_frame"], 250.0);
  EXPECT_EQ(result["processes"]["vo"]["exit_code"], 0);
  EXPECT_EQ(result["configuration"]["vo"]["vo"], (json{{"enabled", true}, {"name", "7"}, {"list", {1, 2.5}}}));
}

TEST(RunSummary, FiguresOfTheInertialSensor) {
  const RunStatistics statistics = TwoFrames();
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  EXPECT_TRUE(SummaryToJson(summary)["imu"].is_null());
  EXPECT_THAT(SummaryToText(SummaryToJson(summary), false), testing::Not(testing::HasSubstr("innovation")));
  summary.counters.Take(1, kImuUsed, 1.0);
  summary.counters.Take(1, kImuInnovation, 1.02);
  summary.counters.Take(1, kImuDelay, -8.5);
  summary.counters.Take(1, kImuDelaySigma, 0.25);
  summary.counters.Take(1, kImuRateBias[0], -0.001);
  const json result = SummaryToJson(summary);
  EXPECT_EQ(result["imu"]["used_frames"], 1);
  EXPECT_NEAR(result["imu"]["innovation"].get<double>(), 1.02, 1e-9);
  EXPECT_NEAR(result["imu"]["delay_ms"].get<double>(), -8.5, 1e-9);
  EXPECT_EQ(result["imu"]["rate_bias_rad_s"], (json{-0.001, 0.0, 0.0}));
  EXPECT_THAT(SummaryToText(result, false), testing::HasSubstr("used in 1 of 2 frames, normalised innovation 1.02"));
}

MapStatistics TwoVersions() {
  MapUpdate head;
  head.source = 5;
  head.version = 1;
  head.totals = {2, 100, 20, 250, 50};
  head.adjustment.n_points = 100;
  head.adjustment.reprojection_before_px = 1.0;
  head.adjustment.reprojection_after_px = 0.5;
  head.stage_ms = {{"adjust", 10.0}, {"update", 20.0}};
  MapStatistics map;
  map.Add(head);
  head.version = 2;
  head.totals = {3, 110, 20, 330, 50};
  head.adjustment.reprojection_before_px = 2.0;
  head.stage_ms = {{"adjust", 20.0}, {"update", 30.0}};
  map.Add(head);
  return map;
}

/// Returns the statistics of a map that was loaded with loops and has nothing else.
MapStatistics OneVersion(int64_t loops) {
  MapUpdate head;
  head.source = 5;
  head.version = 1;
  head.totals.loops = loops;
  MapStatistics map;
  map.Add(head);
  return map;
}

TEST(RunSummary, MapContentAndTimings) {
  const RunStatistics statistics = TwoFrames();
  const MapStatistics map = TwoVersions();
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.map = &map;
  summary.live_ate_m = 0.25;
  const json result = SummaryToJson(summary);
  EXPECT_EQ(result["landmarks"], (json{{"points", 110}, {"lines", 20}}));
  EXPECT_EQ(result["map"]["keyframes"], 3);
  EXPECT_EQ(result["map"]["observations_per_point"], 3.0);
  EXPECT_EQ(result["map"]["observations_per_line"], 2.5);
  EXPECT_EQ(result["map"]["reprojection_before_px"], 1.5);
  EXPECT_EQ(result["map"]["reprojection_after_px"], 0.5);
  EXPECT_NEAR(result["map"]["adjustment_ms"]["median"].get<double>(), 10.0, 0.06);
  EXPECT_NEAR(result["map"]["adjustment_ms"]["p95"].get<double>(), 20.0, 0.11);
  EXPECT_NEAR(result["map"]["update_ms"]["p95"].get<double>(), 30.0, 0.16);
  EXPECT_NEAR(result["accuracy_live_ate_m"].get<double>(), 0.25, 1e-9);
  const std::string text = SummaryToText(result, true);
  EXPECT_THAT(text, testing::HasSubstr("3 keyframes, 110 points, 20 lines; 3.0 observations per point, 2.5 per line, "
                                       "reprojection 1.500 -> 0.500"));
  EXPECT_THAT(text, testing::HasSubstr("map, ms per keyframe"));
}

TEST(RunSummary, LoopsOfTheLoadedMapAreNotCounted) {
  const RunStatistics statistics = TwoFrames();
  const MapStatistics map = OneVersion(7);
  LoopStatistics loops;
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.map = &map;
  summary.loops = &loops;
  EXPECT_EQ(SummaryToJson(summary)["loops"], 0);
  EXPECT_EQ(SummaryToJson(summary)["map"]["loops"], 7);
  loops.Add(LoopClosure::Kind::kLoop, 0.0, 3.0);
  loops.Add(LoopClosure::Kind::kAdjustment, 0.0, 9.0);
  loops.Add(LoopClosure::Kind::kNone, 1.0, 0.0);
  EXPECT_EQ(SummaryToJson(summary)["loops"], 1);
  EXPECT_THAT(SummaryToText(SummaryToJson(summary)), testing::HasSubstr(", 1 loop\n"));
}

TEST(RunSummary, ShareOfTrackedFramesIsOfAllFrames) {
  RunStatistics statistics = TwoFrames();
  FrameReport late;
  late.frame_id = 5;
  late.state = TrackingState::kTracking;
  late.skipped_frames = 3;
  statistics.AddFrame(late);
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.frames.unreadable = 4;
  summary.frames.lost = 1;
  summary.frames.unanswered = 2;
  const json result = SummaryToJson(summary);
  EXPECT_EQ(result["all_frames"], 13);
  EXPECT_EQ(result["frames"], 4);
  EXPECT_EQ(result["tracked_percent"], 23.0);
  EXPECT_THAT(
      SummaryToText(result),
      testing::HasSubstr("frames     3 of 13 tracked (23.0 %), 1 lost, 3 skipped, 4 unreadable, 2 unanswered\n"));
}

TEST(RunSummary, BadRunGivesWarnings) {
  RunStatistics statistics;
  for (int id = 0; id < 10; ++id) {
    FrameReport frame;
    frame.frame_id = id;
    frame.state = id == 9 ? TrackingState::kTracking : TrackingState::kInitialising;
    statistics.AddFrame(frame);
  }
  RunSummary summary;
  summary.dataset = "dark";
  summary.completed = true;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  const json result = SummaryToJson(summary);
  ASSERT_EQ(result["warnings"].size(), 1U) << result["warnings"].dump(1);
  EXPECT_EQ(result["warnings"][0]["code"], "little_tracked");
  EXPECT_EQ(result["warnings"][0]["numbers"]["percent"], 10.0);
  EXPECT_THAT(SummaryToText(result), testing::HasSubstr("dark completed (1 warning)\n"));
  summary.frames.Count(TrackingState::kLost, -1);
  summary.counters.Take(1, kFramesDark, 9.0);
  EXPECT_THAT(SummaryToText(SummaryToJson(summary)), testing::HasSubstr("dark completed (2 warnings)\n"));
}

TEST(RunSummary, FitsInADozenLines) {
  const RunStatistics statistics = TwoFrames();
  const MapStatistics map = TwoVersions();
  const LoopStatistics loops;
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.map = &map;
  summary.loops = &loops;
  summary.path_m = 12.345;
  summary.messages = {3, 2, 1};
  summary.processes = {{"vo", 0.5, 80.0, 1, 0, 0.4, 3.0}};
  const std::string text = SummaryToText(SummaryToJson(summary));
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 10) << text << "and two to tell where to look";
  EXPECT_THAT(text, testing::HasSubstr("  path       12.35 m\n"));
  EXPECT_THAT(
      text, testing::HasSubstr("  speed      10.0 ms per frame (95 % below 11.0), poses 12.0 ms after their frames"));
  EXPECT_THAT(text, testing::HasSubstr("  restarts   vo 1\n"));
  EXPECT_THAT(text, testing::HasSubstr("  messages   1 lost, 2 sent again, 1 rejected\n"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("CPU")));
}

TEST(RunSummary, InfiniteFiguresAreNotPrinted) {
  const RunStatistics statistics = TwoFrames();
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  const double inf = std::numeric_limits<double>::infinity();
  summary.live_ate_m = inf;
  summary.path_m = inf;
  summary.accuracy = json{{"ate_m", 1.0}, {"true_path_m", inf}, {"kitti", {{"segments", 1}, {"t_rel_percent", inf}}}};
  const std::string text = SummaryToText(SummaryToJson(summary), true);
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("inf")));
}

TEST(RunSummary, WithoutAMapItIsNull) {
  const RunStatistics statistics = TwoFrames();
  const MapStatistics map;
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.map = &map;
  const json result = SummaryToJson(summary);
  EXPECT_TRUE(result["map"].is_null());
  EXPECT_TRUE(result["accuracy_live_ate_m"].is_null());
  EXPECT_EQ(result["landmarks"], (json{{"points", 0}, {"lines", 1}}));
}

TEST(MapStatistics, TheWholeMapAgainChangesNothing) {
  MapStatistics map = TwoVersions();
  MapUpdate again;
  again.source = 5;
  again.version = 2;
  map.Add(again);
  EXPECT_EQ(map.totals().points, 110);
  EXPECT_EQ(map.ReprojectionBefore_px(), 1.5);
  again.source = 6;
  again.version = 1;
  again.totals = {1, 7, 0, 7, 0};
  map.Add(again);
  EXPECT_EQ(map.totals().points, 7) << "mapping was started again";
  EXPECT_EQ(map.ReprojectionBefore_px(), 1.5);
  EXPECT_EQ(map.ObservationsPerLine(), 0.0);
}

TEST(RunSummary, SignalThatEndedAProcessIsNamed) {
  const RunStatistics statistics = TwoFrames();
  RunSummary summary;
  summary.statistics = &statistics;
  summary.processes = {{"vo", 0.5, 80.0, 0, 0, 0.0, 0.0}, {"mapping", 0.5, 80.0, 0, 137, 0.0, 0.0, 9}};
  const json processes = SummaryToJson(summary)["processes"];
  EXPECT_FALSE(processes["vo"].contains("exit_signal"));
  EXPECT_EQ(processes["mapping"]["exit_code"], 137);
  EXPECT_EQ(processes["mapping"]["exit_signal"], "SIGKILL");
}

TEST(RunSummary, RunWithoutAFrame) {
  const RunStatistics statistics;
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.reason = "vo ended with exit code 1";
  summary.processes = {{"vo", 0.5, 80.0, 1, {}, 0.0, 0.0}};
  const json result = SummaryToJson(summary);
  EXPECT_EQ(result["processes"]["vo"]["cpu_ms_per_frame"], 0.0);
  EXPECT_TRUE(result["processes"]["vo"]["exit_code"].is_null());
  EXPECT_TRUE(result["accuracy"].is_null());
  const std::string text = SummaryToText(result);
  EXPECT_THAT(text, testing::HasSubstr("NOT completed: vo ended with exit code 1"));
  EXPECT_THAT(text, testing::HasSubstr("no ground truth"));
}

TEST(RunSummary, RunThatTheUserEndedIsNoFailure) {
  const RunStatistics statistics = TwoFrames();
  RunSummary summary;
  summary.dataset = "rig.yaml";
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.reason = kInterrupted;
  EXPECT_THAT(SummaryToText(SummaryToJson(summary)), testing::HasSubstr("rig.yaml ended by the user\n"));
  summary.reason = "interrupted; viewer ended with exit code 1";
  EXPECT_THAT(SummaryToText(SummaryToJson(summary)), testing::HasSubstr("NOT completed: interrupted; viewer ended"));
}

TEST(RunSummary, TextHasTheMainFigures) {
  const RunStatistics statistics = TwoFrames();
  RunSummary summary;
  summary.dataset = "kitti_03";
  summary.completed = true;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  const json exact = {{"n", 3}, {"rmse", 0.5}}, none = {{"n", 0}, {"rmse", 0.0}};
  summary.accuracy = json{{"ate_m", 0.0123},
                          {"true_path_m", 40.0},
                          {"rpe",
                           {{{"delta", "1 frame"}, {"translation_m", exact}, {"rotation_deg", exact}},
                            {{"delta", "1 m"}, {"translation_m", none}, {"rotation_deg", none}}}},
                          {"kitti", {{"segments", 2}, {"t_rel_percent", 1.25}}}};
  const std::string text = SummaryToText(SummaryToJson(summary));
  EXPECT_THAT(text, testing::HasSubstr("kitti_03 completed\n"));
  EXPECT_THAT(text, testing::HasSubstr("2 of 2 tracked (100.0 %)\n"));
  EXPECT_THAT(text, testing::HasSubstr("ATE 0.0123 m, KITTI t_rel 1.250 %, true path 40.0 m\n"));
  EXPECT_THAT(SummaryToText(SummaryToJson(summary), true),
              testing::HasSubstr("true path 40.0 m, RPE over 1 frame 0.5000 m 0.500 deg\n"));
}

TEST(RunSummary, UnmeasuredFiguresAreADash) {
  const RunStatistics statistics = TwoFrames();
  const MapStatistics map = OneVersion(0);
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.map = &map;
  summary.accuracy = json{{"ate_m", nullptr}, {"note", "the estimate has no pose"}};
  const json result = SummaryToJson(summary);
  EXPECT_TRUE(result["map"]["reprojection_before_px"].is_null());
  const std::string text = SummaryToText(result, true);
  EXPECT_THAT(text, testing::HasSubstr("reprojection - -> - px"));
  EXPECT_THAT(text, testing::HasSubstr("accuracy   ATE -: the estimate has no pose"));
}

TEST(RunSummary, InvalidUtf8IsReplaced) {
  const RunStatistics statistics;
  RunSummary summary;
  summary.statistics = &statistics;
  summary.frames = statistics.frames();
  summary.dataset = "a\xff";
  EXPECT_THAT(JsonText(SummaryToJson(summary)), testing::HasSubstr("\"dataset\": \"a\xEF\xBF\xBD\""));
}

TEST(RunStatistics, ManyStageNamesAreBounded) {
  RunStatistics statistics;
  for (int id = 0; id < 1000; ++id) {
    FrameReport frame;
    frame.frame_id = id;
    frame.stage_ms = {{"total", 1.0}, {"stage" + std::to_string(id), 1.0}};
    statistics.AddFrame(frame);
  }
  EXPECT_EQ(statistics.stage_ms().size(), StageTimes::kMaxStages);
  EXPECT_TRUE(statistics.stage_ms().contains("total"));
}

TEST(YamlToJson, BrokenYamlStaysText) { EXPECT_EQ(YamlToJson("a: [1"), json("a: [1")); }

TEST(YamlToJson, EmptyIsNull) { EXPECT_TRUE(YamlToJson("").is_null()); }

}  // namespace
}  // namespace plslam::launcher
