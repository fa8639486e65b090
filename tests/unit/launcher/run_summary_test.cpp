#include "tools/plslam/run_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/plslam/yaml_to_json.h"

namespace plslam {
namespace {

using nlohmann::json;

RunStatistics TwoFrames() {
  RunStatistics statistics;
  for (int id = 0; id < 2; ++id) {
    FrameReport frame;
    frame.frame_id = id;
    frame.state = id;
    frame.keyframe_id = id == 0 ? 0 : -1;
    frame.stage_ms = {{"total", 10.0 + id}};
    statistics.AddFrame(frame);
  }
  statistics.AddLandmark(0, 3, true);
  return statistics;
}

TEST(RunSummary, JsonHasTheKeysThatUsersReadByName) {
  const RunStatistics statistics = TwoFrames();
  RunSummary summary;
  summary.dataset = "synthetic:room";
  summary.version = "1";
  summary.completed = true;
  summary.statistics = &statistics;
  summary.accuracy = json{{"ate_m", 0.01}};
  summary.messages = {3, 2, 1};
  summary.processes = {{"vo", 0.5, 80.0, 1, 0}};
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
  EXPECT_EQ(result["processes"]["vo"]["cpu_ms_per_frame"], 250.0);
  EXPECT_EQ(result["processes"]["vo"]["exit_code"], 0);
  EXPECT_EQ(result["configuration"]["vo"]["vo"], (json{{"enabled", true}, {"name", "7"}, {"list", {1, 2.5}}}));
}

TEST(RunSummary, RunWithoutAFrame) {
  const RunStatistics statistics;
  RunSummary summary;
  summary.statistics = &statistics;
  summary.reason = "vo ended with exit code 1";
  summary.processes = {{"vo", 0.5, 80.0, 1, {}}};
  const json result = SummaryToJson(summary);
  EXPECT_EQ(result["processes"]["vo"]["cpu_ms_per_frame"], 0.0);
  EXPECT_TRUE(result["processes"]["vo"]["exit_code"].is_null());
  EXPECT_TRUE(result["accuracy"].is_null());
  const std::string text = SummaryToText(result);
  EXPECT_THAT(text, testing::HasSubstr("NOT completed: vo ended with exit code 1"));
  EXPECT_THAT(text, testing::HasSubstr("no ground truth"));
}

TEST(RunSummary, TextTellsTheMainFigures) {
  const RunStatistics statistics = TwoFrames();
  RunSummary summary;
  summary.dataset = "kitti_03";
  summary.completed = true;
  summary.statistics = &statistics;
  const json exact = {{"n", 3}, {"rmse", 0.5}}, none = {{"n", 0}, {"rmse", 0.0}};
  summary.accuracy = json{{"ate_m", 0.0123},
                          {"true_path_m", 40.0},
                          {"rpe",
                           {{{"delta", "1 frame"}, {"translation_m", exact}, {"rotation_deg", exact}},
                            {{"delta", "1 m"}, {"translation_m", none}, {"rotation_deg", none}}}},
                          {"kitti", {{"segments", 2}, {"t_rel_percent", 1.25}}}};
  const std::string text = SummaryToText(SummaryToJson(summary));
  EXPECT_THAT(text, testing::HasSubstr("kitti_03 completed"));
  EXPECT_THAT(text, testing::HasSubstr("2 tracked (100.0 %)"));
  EXPECT_THAT(text, testing::HasSubstr(
                        "ATE 0.0123 m, RPE over 1 frame 0.5000 m 0.500 deg, KITTI t_rel 1.250 %, path 40.0 m"));
}

TEST(YamlToJson, BrokenYamlStaysText) { EXPECT_EQ(YamlToJson("a: [1"), json("a: [1")); }

TEST(YamlToJson, EmptyIsNull) { EXPECT_TRUE(YamlToJson("").is_null()); }

}  // namespace
}  // namespace plslam
