// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/comparison.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "core/io/trajectories/trajectory.h"
#include "tests/support/text_file.h"
#include "tools/evaluate/compare/comparison_page.h"
#include "tools/evaluate/compare/comparison_text.h"

namespace plslam::evaluate {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

json Summary(const std::string& dataset, const std::string& features, double ate_m) {
  json summary = json::parse(R"json({"completed": true, "reason": "", "version": "1 (abc)", "frames": 40,
    "tracked_frames": 38, "keyframes": 7, "loops": 1, "wall_s": 2.5, "accuracy_live_ate_m": 0.5,
    "stage_ms": {"total": {"median": 20.0, "p95": 31.0}},
    "accuracy": {"ate_m": 0, "kitti": {"segments": 0, "t_rel_percent": 0},
                 "kitti_short": {"segments": 3, "t_rel_percent": 0.75},
                 "keyframes": {"moving": 6, "relative_rmse": 0.01}},
    "processes": {"vo": {"cpu_ms_per_frame": 20.0, "peak_memory_mb": 80},
                  "mapping": {"cpu_ms_per_frame": 5.5, "peak_memory_mb": 30}},
    "configuration": {
  "vo" : {"bus" : {"url" : "udpm://1"}, "vo" : {"features" : {"features" : "both"}, "n" : 3}},
         "mapping" : {"mapping" : {"save" : "a.plmap"}},
                     "player" : {"player" : {"dataset" : "x", "pace" : "lockstep"}},
                                "viewer" : {
    "viewer" : { "out" : "y" }
  }}})json");
  summary["dataset"] = dataset;
  summary["accuracy"]["ate_m"] = ate_m;
  summary["configuration"]["vo"]["vo"]["features"]["features"] = features;
  // Every run has its own port.
  summary["configuration"]["vo"]["bus"]["url"] = std::to_string(ate_m);
  summary["configuration"]["viewer"]["viewer"]["out"] = std::to_string(ate_m);
  return summary;
}

std::vector<RunRecord> SomeRuns() {
  std::vector<RunRecord> runs;
  const auto add = [&](const std::string& dataset, const std::string& features, double ate_m) {
    runs.push_back(RecordOf(Summary(dataset, features, ate_m), "run" + std::to_string(runs.size())));
  };
  add("synthetic:room?seed=1&rate=10", "both", 0.1);
  add("kitti_03", "both", 1.0);
  add("synthetic:room?rate=10&seed=2", "both", 0.4);
  add("synthetic:room?seed=1&rate=10", "points", 0.3);
  add("synthetic:room?rate=10", "both", 0.2);
  return runs;
}

double At(const RunGroup& group, const std::string& key, double Spread::*what) {
  for (size_t i = 0; i < Metrics().size(); ++i) {
    if (Metrics()[i].key == key) return group.metrics[i].*what;
  }
  ADD_FAILURE() << key;
  return 0.0;
}

TEST(SpreadOf, OddEvenAndNone) {
  const Spread odd = SpreadOf({3.0, 1.0, 2.0}, false);
  EXPECT_EQ(std::tuple(odd.n, odd.median, odd.worst, odd.spread), std::tuple(3, 2.0, 3.0, 2.0));
  const Spread even = SpreadOf({4.0, 1.0, 2.0, 3.0}, true);
  EXPECT_EQ(std::tuple(even.n, even.median, even.worst, even.spread), std::tuple(4, 2.5, 1.0, 3.0));
  EXPECT_EQ(SpreadOf({}, false).n, 0);
}

TEST(Compare, SeedsAreOneGroupAndFeaturesAreTwo) {
  const std::vector<RunGroup> groups = Compare(SomeRuns());
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].dataset, "synthetic:room?rate=10");
  EXPECT_EQ(groups[0].label, "features=both");
  EXPECT_EQ(groups[1].dataset, "synthetic:room?rate=10");
  EXPECT_EQ(groups[1].label, "features=points");
  EXPECT_EQ(groups[2].dataset, "kitti_03");
  EXPECT_EQ(groups[0].runs.size(), 3U);
  EXPECT_NEAR(At(groups[0], "ate_m", &Spread::median), 0.2, 1e-12);
  EXPECT_NEAR(At(groups[0], "ate_m", &Spread::worst), 0.4, 1e-12);
  EXPECT_NEAR(At(groups[0], "ate_m", &Spread::spread), 0.3, 1e-12);
  EXPECT_NEAR(At(groups[0], "tracked_percent", &Spread::median), 95.0, 1e-12);
  EXPECT_NEAR(At(groups[0], "t_rel_percent", &Spread::median), 0.75, 1e-12);
  EXPECT_NEAR(At(groups[0], "cpu_ms", &Spread::median), 25.5, 1e-12);
  EXPECT_NEAR(At(groups[0], "memory_mb", &Spread::median), 110.0, 1e-12);
  EXPECT_EQ(groups[0].Typical()->folder, "run4");
}

TEST(Compare, FailedRunsAreCountedWithoutFigures) {
  json failed = Summary("a", "both", 9.0);
  failed["completed"] = false;
  failed["reason"] = "vo_process has crashed";
  const auto groups = Compare({RecordOf(Summary("a", "both", 1.0), "good"), RecordOf(failed, "bad")});
  ASSERT_EQ(groups.size(), 1U);
  EXPECT_EQ(groups[0].label, "same options");
  EXPECT_EQ(groups[0].failed, 1);
  EXPECT_EQ(At(groups[0], "ate_m", &Spread::worst), 1.0);
  EXPECT_THAT(ComparisonMarkdown(groups), HasSubstr("| 2 (1 failed) |"));
  EXPECT_THAT(ComparisonPage(groups), HasSubstr("vo_process has crashed"));
  const auto none = Compare({RecordOf(failed, "bad")});
  EXPECT_EQ(none[0].Typical(), nullptr);
  EXPECT_THAT(ComparisonText(none), HasSubstr("1 (1 failed)"));
}

TEST(Compare, ReplaysHaveTheDatasetOfTheirRecording) {
  json recorded = Summary("synthetic:room?seed=3", "both", 1.0), again = Summary("/x/a.lcm", "both", 1.0);
  recorded["recordings"] = {"/x/a.lcm"};
  again["recordings"] = {"/x/b.lcm"};
  std::vector<RunRecord> runs = {RecordOf(Summary("/x/y/../b.lcm", "both", 1.0), "3"), RecordOf(again, "2"),
                                 RecordOf(recorded, "1"), RecordOf(Summary("/x/c.lcm", "both", 1.0), "4")};
  ResolveRecordings(&runs);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(runs[i].played, "synthetic:room?seed=3") << i;
    EXPECT_EQ(runs[i].dataset, "synthetic:room") << i;
  }
  EXPECT_EQ(runs[3].played, "/x/c.lcm");
}

TEST(Compare, ProcessesAndVersionsMakeGroups) {
  json odometry = Summary("a", "both", 1.0), other = Summary("a", "both", 1.0);
  odometry["configuration"].erase("mapping");
  other["version"] = "2";
  const auto groups =
      Compare({RecordOf(Summary("a", "both", 1.0), "1"), RecordOf(odometry, "2"), RecordOf(other, "3")});
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].label, "processes=mapping+vo, version=1 (abc)");
  EXPECT_EQ(groups[1].label, "processes=vo, version=1 (abc)");
  EXPECT_EQ(groups[2].label, "processes=mapping+vo, version=2");
}

TEST(Compare, OptionsOfAMissingProcessAreNoDifference) {
  json odometry = Summary("a", "both", 1.0), lines = Summary("a", "lines", 1.0);
  odometry["configuration"].erase("mapping");
  odometry["configuration"]["player"]["player"]["kind"] = "kitti";
  const auto groups =
      Compare({RecordOf(Summary("a", "both", 1.0), "1"), RecordOf(odometry, "2"), RecordOf(lines, "3")});
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].label, "processes=mapping+vo, features=both");
  EXPECT_EQ(groups[1].label, "processes=vo, features=both");
}

TEST(Compare, RestartedPlayerIsNotAnotherOption) {
  json restarted = Summary("a", "both", 1.0);
  restarted["configuration"]["player"]["player"]["resume_after"] = "17@1700000000";
  const auto groups = Compare({RecordOf(Summary("a", "both", 1.0), "1"), RecordOf(restarted, "2")});
  ASSERT_EQ(groups.size(), 1U);
  EXPECT_EQ(groups[0].runs.size(), 2U);
}

TEST(Compare, TrackedShareIsOfAllFrames) {
  json late = Summary("a", "both", 1.0);
  late["skipped_frames"] = 30;
  late["bad_frames"] = 6;
  EXPECT_NEAR(At(Compare({RecordOf(late, "1")})[0], "tracked_percent", &Spread::median), 50.0, 1e-12);
  late["unanswered_frames"] = 76;
  late["all_frames"] = 152;
  EXPECT_NEAR(At(Compare({RecordOf(late, "1")})[0], "tracked_percent", &Spread::median), 25.0, 1e-12);
}

TEST(Compare, NearlyEmptySummaries) {
  const auto groups = Compare({RecordOf(json::object(), "empty"),
                               RecordOf(R"({"completed": true, "accuracy": null, "map": null})"_json, "bare")});
  ASSERT_EQ(groups.size(), 1U);
  EXPECT_EQ(TableOf(groups).columns, (std::vector<std::string>{"dataset", "configuration", "runs"}));
  EXPECT_TRUE(Compare({}).empty());
  EXPECT_THAT(ComparisonPage({}), HasSubstr("</html>"));
}

TEST(ComparisonText, FormatsAgree) {
  const auto groups = Compare(SomeRuns());
  EXPECT_THAT(ComparisonText(groups), HasSubstr("features=both, 3 runs: median (worst), spread"));
  EXPECT_THAT(ComparisonMarkdown(groups), HasSubstr("| features=both | 3 | 0.2000 (0.4000) |"));
  EXPECT_THAT(ComparisonLatex(groups), HasSubstr("kitti\\_03 & features=both & 1 & 1.0000 & "));
  EXPECT_THAT(ComparisonCsv(groups), HasSubstr("synthetic:room?rate=10,features=both,3,0,ate_m,3,0.2,0.4,0.3\n"));
  const auto parsed = ComparisonJson(groups);
  EXPECT_EQ(parsed[0]["metrics"]["ate_m"]["n"], 3);
  EXPECT_EQ(parsed[0]["runs"][1]["ate_m"], 0.4);
}

TEST(ComparisonPage, NeedsNothingFromElsewhereAndEscapesNames) {
  auto runs = SomeRuns();
  runs[1].dataset = "<b>&\"";
  const std::string page = ComparisonPage(Compare(runs));
  EXPECT_THAT(page, HasSubstr("<h2>&lt;b&gt;&amp;&quot;</h2>"));
  EXPECT_THAT(page, HasSubstr("<svg role=\"img\" aria-label=\"ate_m\" "));
  EXPECT_THAT(page, Not(HasSubstr("<?xml")));
  // Version 1.18 of cairo puts a hyphen in between.
  EXPECT_THAT(page, AllOf(ContainsRegex("id=\"d0_ate_m_glyph-?0-1\""), ContainsRegex("id=\"d1_ate_m_glyph-?0-1\"")));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("src=")));
  EXPECT_THAT(page,
              HasSubstr("<td class=\"best\">0.2000<small>worst 0.4000</small><small>spread 0.3000</small></td>"));
  EXPECT_THAT(page, HasSubstr("vo.features.features"));
}

/// A quarter of an hour at 20 Hz along a curve, with the noise of an estimate.
Trajectory LongPath(int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  std::normal_distribution<double> noise(0.0, 0.01);
  Trajectory path;
  for (int i = 0; i < 18'000; ++i) {
    const double s = 1e-3 * i;
    const Eigen::Vector3d p{100.0 * std::sin(s), noise(random), 60.0 * std::sin(1.7 * s) + noise(random)};
    path.push_back({int64_t{i} * 50'000'000, {Eigen::Quaterniond::Identity(), p}});
  }
  return path;
}

TEST(ComparisonPage, PathsOfLongRunsAreThinned) {
  const ScratchFolder folder;
  std::vector<RunRecord> runs;
  for (const char* features : {"both", "points", "lines"}) {
    const std::string run = folder.Path(features);
    std::filesystem::create_directories(run);
    WriteTrajectory(run + "/trajectory.tum", TrajectoryFormat::kTum, LongPath(static_cast<int>(runs.size())));
    WriteTrajectory(run + "/groundtruth.tum", TrajectoryFormat::kTum, LongPath(99));
    runs.push_back(RecordOf(Summary("kitti_03", features, 0.1), run));
  }
  const std::string page = ComparisonPage(Compare(runs));
  EXPECT_THAT(page, HasSubstr("aria-label=\"trajectories\""));
  EXPECT_LT(page.size(), 300'000U);
}

TEST(Comparison, RunWithoutTrackedFramesIsNotGood) {
  json nothing = Summary("kitti_03", "both", 0.0);
  nothing["accuracy"]["poses"] = {{"estimated", 0}, {"true", 40}, {"associated", 0}};
  const auto groups = Compare({RecordOf(Summary("kitti_03", "both", 0.3), "a"), RecordOf(nothing, "b")});
  ASSERT_EQ(groups.size(), 1U);
  EXPECT_EQ(groups[0].untracked, 1);
  EXPECT_NEAR(At(groups[0], "ate_m", &Spread::median), 0.3, 1e-12);
  EXPECT_THAT(ComparisonText(groups), HasSubstr("2 (1 without ATE) runs"));
  EXPECT_TRUE(nlohmann::json(ComparisonJson(groups))[0]["runs"][1]["ate_m"].is_null());
}

}  // namespace
}  // namespace plslam::evaluate
