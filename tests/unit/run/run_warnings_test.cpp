// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/run_warnings.h"

#include <gmock/gmock.h>

#include <limits>

namespace plslam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> CodesOf(const RunFindings& findings) {
  std::vector<std::string> codes;
  for (const RunWarning& warning : WarningsOf(findings)) codes.push_back(warning.code);
  return codes;
}

RunFindings GoodRun() {
  RunFindings findings;
  findings.dataset = "/data/kitti 03";
  findings.frames.tracked = 100;
  findings.points_seen = 80'000;
  findings.points_matched = 60'000;
  findings.ate_m = 0.06;
  findings.true_spread_m = 20.0;
  findings.nees_pose = 30.0;
  findings.nees_poses = 99;
  findings.truth_frames = 100;
  findings.recordings = {"a.lcm"};
  findings.frames_captured = 100;
  return findings;
}

TEST(RunWarnings, GoodRunHasNone) {
  EXPECT_THAT(CodesOf(GoodRun()), IsEmpty());
  EXPECT_THAT(CodesOf(RunFindings()), IsEmpty()) << "nothing is known";
}

TEST(RunWarnings, ConditionsOfEachRow) {
  struct Case {
    const char* code;
    void (*change)(RunFindings& f);
    const char* says;
  };
  const Case cases[] = {
      {"nothing_tracked", [](RunFindings& f) { f.frames = {.initialising = 50}; },
       "none of the 50 frames was tracked (50 init"},
      {"little_tracked", [](RunFindings& f) { f.frames = {.tracked = 12, .initialising = 100, .lost = 8}; },
       "only 12 of 120 frames were tracked (10.0 %; 100 initialising, 8 lost)"},
      {"not_in_map", [](RunFindings& f) { f.frames_unanchored = 58; },
       "58 of 100 frames were not recognised in the map"},
      {"not_in_map",
       [](RunFindings& f) {
         f.frames_unanchored = f.unanchored_now = 12;
         f.map = "room.plmap";
       },
       "12 of 100 frames, the last 12 among them, were not recognised in room.plmap"},
      {"few_stereo_matches",
       [](RunFindings& f) {
         f.frames_captured = 0;
         f.points_matched = 800;
       },
       "only 1.0 % of the points of the left ones: left and right may be exchanged, not taken at the same time, or "
       "badly calibrated (check with `plslam rectify-check '/data/kitti 03'`), or each image shows rain, snow or "
       "dirt"},
      {"repeated_texture",
       [](RunFindings& f) {
         f.points_seen = 10'000;
         f.points_ambiguous = 3'400;
       },
       "34 % of the points have several equally good matches in their row"},
      {"cameras_out_of_step",
       [](RunFindings& f) {
         f.frames_captured = 0;
         f.right_late_ms = 93.04;
         f.late_frames = 0.9;
         f.corner_rows_px = 12.0;
       },
       "the right images are taken 93 ms after the left ones: pair them again with `--set "
       "player.right_offset_frames=-1`"},
      {"readout_differs", [](RunFindings& f) { f.unequal_readout_ms = 12.5; }, "takes 12.5 ms longer"},
      {"rolling_shutter",
       [](RunFindings& f) {
         f.readout_ms = 24.96;
         f.readout_path_mm = 31.4;
       },
       "within 25.0 ms (rolling shutter), in which the camera moves up to 31 mm"},
      {"readout_contradicted", [](RunFindings& f) { f.other_readout_ms = 12.04; }, "are read within 12.0 ms"},
      {"dirty_lens",
       [](RunFindings& f) {
         f.lens_dirt_percent = 3.14;
         f.lens_dirt_u_px = 412.0;
         f.lens_dirt_v_px = 133.0;
       },
       "dirt on the left lens, or text burnt into its images, covers 3.1 % of the image, most of it near pixel (412, "
       "133)"},
      {"dirty_right_lens",
       [](RunFindings& f) {
         f.right_lens_dirt_percent = 1.26;
         f.right_lens_dirt_u_px = 17.0;
         f.right_lens_dirt_v_px = 90.0;
       },
       "dirt on the right lens, or text burnt into its images, covers 1.3 % of the image, most of it near pixel (17, "
       "90)"},
      {"rows_corrected_far", [](RunFindings& f) { f.corner_rows_px = 12.34; }, "by up to 12.3 px in the corners"},
      {"disparities_off",
       [](RunFindings& f) {
         f.length_error_percent = 9.06;
         f.length_sigma_percent = 1.23;
       },
       "an offset that would change lengths at the median depth by 9 % (sigma 1 %): it is corrected"},
      {"dark_images", [](RunFindings& f) { f.dark_frames = 30; }, "30 of 100 frames are nearly black"},
      {"unreadable_frames", [](RunFindings& f) { f.frames.unreadable = 2; }, "2 of 102 frames could not be read"},
      {"skipped_frames", [](RunFindings& f) { f.frames.skipped = 5; }, "5 of 105 frames were skipped"},
      {"missing_pictures", [](RunFindings& f) { f.pictures_missing = 3; }, "3 of 100 frames have no picture"},
      {"truth_of_other_times",
       [](RunFindings& f) {
         f.truth_frames = 0;
         f.truth_missing = 100;
       },
       "none of 100 frames has a true pose"},
      {"truth_of_another_run", [](RunFindings& f) { f.ate_m = 19.0; },
       "off by 19 m (ATE) while the true one extends over 20 m: "},
      {"covariance_not_consistent", [](RunFindings& f) { f.nees_pose = 2'400.0; },
       "errors are about 20 times larger"},
      {"recording_without_index", [](RunFindings& f) { f.recording_scan_s = 3.21; },
       "the recording has no usable index, or is truncated: it was first read completely, which took 3.2 s"},
      {"recording_in_parts",
       [](RunFindings& f) {
         f.recordings = {"a.lcm", "a.lcm.2"};
       },
       "the recorder was restarted, so the recording of a.lcm continues in a.lcm.2"},
      {"cameras_skewed", [](RunFindings& f) { f.skew_ms = 2.34; }, "taken 2.3 ms apart (median)"},
      {"camera_frames_missing",
       [](RunFindings& f) {
         f.frames_missing = 3;
         f.frames_dropped = 2;
       },
       "besides the 100 pairs from the cameras, 3 are missing, and 2 images have no partner"},
      {"badly_exposed",
       [](RunFindings& f) {
         f.frames_overexposed = 20;
         f.dark_frames = 30;
       },
       "of 100 pairs of images, 20 are mostly white and 0 mostly black"},
      {"camera_outages", [](RunFindings& f) { f.outages = 2; }, "sent no frames for a while, 2 times"}};
  std::vector<std::string> codes;
  for (const Case& c : cases) {
    RunFindings findings = GoodRun();
    c.change(findings);
    EXPECT_THAT(CodesOf(findings), ElementsAre(c.code));
    ASSERT_FALSE(WarningsOf(findings).empty()) << c.code;
    EXPECT_THAT(WarningsOf(findings)[0].sentence, HasSubstr(c.says));
    EXPECT_FALSE(WarningsOf(findings)[0].numbers.empty()) << c.code;
    if (codes.empty() || codes.back() != c.code) codes.emplace_back(c.code);
  }
  EXPECT_EQ(codes, WarningCodes()) << "each row is tried";
}

TEST(RunWarnings, DelayBelowAFrameIsNotRepaired) {
  RunFindings findings = GoodRun();
  findings.left_late_ms = 5.0;
  findings.late_frames = 0.1;
  ASSERT_THAT(CodesOf(findings), ElementsAre("cameras_out_of_step"));
  EXPECT_THAT(WarningsOf(findings)[0].sentence,
              HasSubstr("the left images are taken 5 ms after the right ones: this is compensated"));
  findings.left_late_ms = 20.0;
  findings.late_frames = 0.4;
  EXPECT_THAT(WarningsOf(findings)[0].sentence,
              HasSubstr("too much to be compensated: trigger the cameras together"));
}

TEST(RunWarnings, BarelyGoodRunHasNone) {
  RunFindings findings = GoodRun();
  findings.frames = {.tracked = 90, .lost = 9, .skipped = 1};
  findings.dark_frames = 5;
  findings.corner_rows_px = 2.0;
  findings.length_error_percent = 5.0;
  findings.length_sigma_percent = 0.1;
  findings.truth_frames = 5;
  findings.truth_missing = 95;
  EXPECT_THAT(CodesOf(findings), IsEmpty());
  findings.ate_m = 0.01;
  findings.true_spread_m = 0.001;
  EXPECT_THAT(CodesOf(findings), IsEmpty()) << "a camera that stands";
  findings.points_seen = 300;
  findings.points_matched = 0;
  EXPECT_THAT(CodesOf(findings), IsEmpty()) << "a white wall";
}

TEST(RunWarnings, UncertainLengthsAreNotReported) {
  RunFindings findings = GoodRun();
  findings.length_error_percent = 9.0;
  findings.length_sigma_percent = 4.0;
  EXPECT_THAT(CodesOf(findings), IsEmpty());
}

TEST(RunWarnings, SkippedFramesAreReportedOnce) {
  RunFindings findings = GoodRun();
  findings.frames = {.tracked = 88, .skipped = 12};
  ASSERT_THAT(CodesOf(findings), ElementsAre("skipped_frames"));
  EXPECT_THAT(WarningsOf(findings)[0].sentence, HasSubstr("slower than the data: use --pace lockstep, "));
  findings.frames = {.tracked = 60, .lost = 20, .skipped = 12, .unreadable = 8};
  ASSERT_THAT(CodesOf(findings), ElementsAre("little_tracked", "unreadable_frames", "skipped_frames"));
  EXPECT_THAT(WarningsOf(findings)[0].sentence, HasSubstr("only 60 of 80 frames were tracked (75.0 %; 20 lost)"));
}

TEST(RunWarnings, LiveCameraGetsPossibleAdvice) {
  RunCounters counters;
  counters.Take(1, kLiveSource, 1.0);
  RunFindings findings = GoodRun();
  findings.Take(counters);
  findings.frames = {.tracked = 88, .skipped = 12};
  ASSERT_THAT(CodesOf(findings), ElementsAre("skipped_frames"));
  EXPECT_THAT(WarningsOf(findings)[0].sentence,
              HasSubstr("slower than the sensor: use a lower frame rate, smaller images or a faster machine"));
}

TEST(RunWarnings, CamerasGetNoAdviceForDatasets) {
  RunFindings findings = GoodRun();
  findings.frames_captured = 100.0;
  findings.left_late_ms = 98.4;
  findings.late_frames = 0.984;
  ASSERT_THAT(CodesOf(findings), ElementsAre("cameras_out_of_step"));
  EXPECT_THAT(WarningsOf(findings)[0].sentence, testing::EndsWith("trigger the cameras together"));
  EXPECT_THAT(WarningsOf(findings)[0].sentence, testing::Not(HasSubstr("player.")));
  findings = GoodRun();
  findings.frames_captured = 100.0;
  findings.points_matched = 0.0;
  ASSERT_THAT(CodesOf(findings), ElementsAre("few_stereo_matches"));
  EXPECT_THAT(WarningsOf(findings)[0].sentence, HasSubstr("`plslam rectify-check` on a recording of it"));
}

TEST(RunWarnings, InfiniteErrorIsReported) {
  RunFindings findings = GoodRun();
  findings.ate_m = findings.true_spread_m = std::numeric_limits<double>::infinity();
  ASSERT_THAT(CodesOf(findings), ElementsAre("truth_of_another_run"));
  EXPECT_THAT(WarningsOf(findings)[0].sentence, HasSubstr("off by more than can be computed (ATE)"));
}

TEST(RunCounters, CoverAllProcesses) {
  RunCounters counters;
  counters.Take(1, "points.seen", 10.0);
  counters.Take(1, "points.seen", 20.0);
  counters.Take(2, "points.seen", 5.0);
  counters.Take(1, "queue.frames", 5.0);
  counters.Take(3, "points.seen", std::numeric_limits<double>::quiet_NaN());
  counters.Take(1, "rows.corner_px", 3.0);
  counters.Take(2, "rows.corner_px", 4.0);
  EXPECT_EQ(counters.Sum("points.seen"), 25.0);
  EXPECT_EQ(counters.Sum("queue.frames"), 0.0);
  EXPECT_EQ(counters.Largest("rows.corner_px"), 4.0);
  EXPECT_FALSE(counters.Newest("rows.corner_px"));
}

TEST(RunCounters, NewestEstimatesOfTheInertialSensor) {
  RunCounters counters;
  EXPECT_FALSE(ImuFiguresOf(counters));
  counters.Take(1, kImuUsed, 40.0);
  counters.Take(1, kImuInnovation, 7.0);
  counters.Take(1, kImuForceBias[2], 0.4);
  counters.Take(2, kImuUsed, 2.0);
  counters.Take(2, kImuInnovation, 1.25);
  counters.Take(2, kImuRateBias[1], -0.5);
  counters.Take(2, kImuForceBias[2], -0.25);
  counters.Take(2, kImuForceBiasSigma, 0.125);
  counters.Take(2, kImuForceBiasSigma, std::numeric_limits<double>::quiet_NaN());
  const std::optional<ImuFigures> figures = ImuFiguresOf(counters);
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->used_frames, 42) << "of both trackers";
  EXPECT_EQ(figures->innovation, 1.25);
  EXPECT_THAT(figures->rate_bias_rad_s, ElementsAre(0.0, -0.5, 0.0));
  EXPECT_THAT(figures->force_bias_m_s2, ElementsAre(0.0, 0.0, -0.25));
  EXPECT_EQ(figures->force_bias_sigma_m_s2, 0.125);
  EXPECT_FALSE(figures->delay) << "none is significant";
  counters.Take(2, kImuDelay, -8.0);
  counters.Take(2, kImuDelaySigma, 0.5);
  EXPECT_EQ(ImuFiguresOf(counters)->delay->ms, -8.0);
}

}  // namespace
}  // namespace plslam
