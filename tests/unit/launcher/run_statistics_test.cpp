// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_statistics.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <utility>

#include "tools/plslam/progress_line.h"

namespace plslam::launcher {
namespace {

FrameReport Frame(int64_t id, int state, int64_t keyframe = -1) {
  FrameReport frame;
  frame.frame_id = FrameId(id);
  frame.state = static_cast<TrackingState>(state);
  frame.keyframe_id = keyframe;
  return frame;
}

TEST(RunStatistics, NothingYet) {
  const RunStatistics s;
  EXPECT_EQ(s.frames().answered(), 0);
  EXPECT_EQ(s.frames().tracked, 0);
  EXPECT_TRUE(s.stage_ms().empty());
}

TEST(RunStatistics, CountsFramesWithAPose) {
  RunStatistics s;
  s.AddFrame(Frame(0, 0));     // nothing seen yet
  s.AddFrame(Frame(1, 0, 0));  // founds the map
  s.AddFrame(Frame(2, 1));
  s.AddFrame(Frame(3, 2));
  s.AddFrame(Frame(4, 3));  // lost
  s.AddFrame(Frame(5, 4, 1));
  EXPECT_EQ(s.frames().answered(), 6);
  EXPECT_EQ(s.frames().tracked, 4);
  EXPECT_EQ(s.keyframes(), 2);
}

TEST(RunStatistics, FrameDoneAgainAfterARestartCountsOnce) {
  RunStatistics s;
  s.AddFrame(Frame(0, 0, 0));
  s.AddFrame(Frame(1, 1));
  s.AddFrame(Frame(1, 0, 0));
  s.AddFrame(Frame(2, 1));
  EXPECT_EQ(s.frames().answered(), 3);
  EXPECT_EQ(s.frames().tracked, 3);
}

TEST(RunStatistics, NoMoreFramesAreSkippedThanThereAre) {
  RunStatistics s;
  FrameReport frame = Frame(4, 1);
  frame.skipped_frames = 2;
  s.AddFrame(frame);
  frame.frame_id = 9;
  frame.skipped_frames = 2'000'000'000;
  s.AddFrame(frame);
  frame.frame_id = 10;
  frame.skipped_frames = -5;
  s.AddFrame(frame);
  EXPECT_EQ(s.frames().skipped, 2 + 4);
}

TEST(RunStatistics, LandmarksOfSessionsAreDistinct) {
  RunStatistics s;
  for (const TrackId id : {4, 4, 5, -1}) s.AddLandmark(1, id, false);
  s.AddLandmark(2, 4, false);
  s.AddLandmark(1, 4, true);
  EXPECT_EQ(s.landmark_points(), 3);
  EXPECT_EQ(s.landmark_lines(), 1);
}

TEST(IdCounter, AgreesWithASet) {
  std::mt19937 random(3);
  std::set<std::pair<SessionId, int64_t>> all;
  IdCounter counter;
  for (int i = 0; i < 20000; ++i) {
    const SessionId session(random() % 3);
    const auto id = static_cast<int64_t>(random() % 30000);
    all.insert({session, id});
    counter.Add(session, id);
  }
  EXPECT_EQ(counter.count(), static_cast<int64_t>(all.size()));
}

TEST(IdCounter, AMillionLandmarksCostAQuarterOfAMegabyte) {
  IdCounter counter;
  for (int64_t id = 0; id < 1'000'000; ++id) counter.Add(7, id);
  EXPECT_EQ(counter.count(), 1'000'000);
  EXPECT_LT(counter.bytes(), 250'000);
}

TEST(IdCounter, RandomIdsCostAtMost40Megabytes) {
  IdCounter counter;
  std::mt19937_64 random(5);
  for (int i = 0; i < 200'000; ++i) counter.Add(1, static_cast<int64_t>(random() >> 1));
  counter.Add(1, INT64_MAX);
  counter.Add(1, INT64_MIN);
  EXPECT_LT(counter.bytes(), 40'000'000);
}

TEST(QuantileSketch, AgreesWithSortingWithinHalfAPercent) {
  std::mt19937 random(7);
  std::lognormal_distribution<double> samples(1.0, 2.0);
  QuantileSketch sketch;
  std::vector<double> all;
  for (int i = 0; i < 5001; ++i) {
    all.push_back(samples(random));
    sketch.Add(all.back());
  }
  std::sort(all.begin(), all.end());
  for (const double q : {0.0, 0.01, 0.5, 0.95, 0.999, 1.0}) {
    const auto rank = static_cast<size_t>(std::max(1.0, std::ceil(q * 5001)));
    EXPECT_NEAR(sketch.Quantile(q) / all[rank - 1], 1.0, 0.0051) << q;
  }
}

TEST(QuantileSketch, FewAndOddValues) {
  QuantileSketch sketch;
  EXPECT_EQ(sketch.Quantile(0.5), 0.0);
  sketch.Add(std::nan(""));
  sketch.Add(std::numeric_limits<double>::infinity());
  EXPECT_EQ(sketch.count(), 0);
  sketch.Add(3.0);
  EXPECT_EQ(sketch.Quantile(0.5), 3.0);
  EXPECT_EQ(sketch.Quantile(0.95), 3.0);
  sketch.Add(0.0);
  sketch.Add(-1.0);
  sketch.Add(1e9);
  EXPECT_EQ(sketch.count(), 4);
  EXPECT_EQ(sketch.Quantile(0.0), 1e-4 * std::exp(0.5 * std::log(1.01)));
}

TEST(ProgressLine, FitsTheWidth) {
  Progress progress{120, 400, 31.25, 210, 74, 9, "tracking", 0, 0, 0, ""};
  EXPECT_EQ(FormatProgress(progress, 200),
            "frame 120/400  31.2/s  9 s left  tracking  points 210  lines 74  keyframes 9  gaps 0");
  progress.total_frames = -1;
  progress.restarts = 2;
  progress.skipped_frames = 5;
  EXPECT_EQ(FormatProgress(progress, 200),
            "frame 120  31.2/s  tracking  points 210  lines 74  keyframes 9  skipped 5  gaps 0  restarts 2");
  progress.total_frames = 400'000;
  EXPECT_THAT(FormatProgress(progress, 200), testing::HasSubstr("31.2/s  3 h 33 min left  tracking"));
  progress.total_frames = 40'000;
  EXPECT_THAT(FormatProgress(progress, 200), testing::HasSubstr("31.2/s  21 min left  tracking"));
  progress.frames = 3;
  EXPECT_THAT(FormatProgress(progress, 200), testing::Not(testing::HasSubstr("left")));
  progress.frames = 120;
  progress.total_frames = -1;
  EXPECT_EQ(FormatProgress(progress, 9), "frame 120");
  EXPECT_EQ(FormatProgress(progress, 0), "");
}

}  // namespace
}  // namespace plslam::launcher
