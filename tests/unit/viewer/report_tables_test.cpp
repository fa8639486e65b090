// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "tests/unit/run/frame_poses.h"
#include "tests/unit/viewer/report_columns.h"
#include "viewer_headless/report/frame_tables.h"
#include "viewer_headless/report/map_tables.h"

namespace plslam::viewer {
namespace {

using testing::ElementsAre;

const Eigen::Quaterniond kUnturned = Eigen::Quaterniond::Identity();

SE3 Random(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector6d x;
  for (double& value : x) value = normal(random);
  return SE3::Exp(x);
}

TEST(FrameTable, RowsHaveThePublishedValues) {
  Recorder recorder;
  for (int64_t id = 0; id < 5; ++id) {
    FramePose pose = SomePose(id, id == 3 ? TrackingState::kLost : TrackingState::kTracking);
    pose.T_w_odom = SE3(kUnturned, {id >= 2 ? 1.0 : 0.0, 0, 0});
    pose.keyframe_id = id == 2 ? 1 : -1;
    ASSERT_TRUE(recorder.AddPose(pose));
  }
  const Table table = FrameTable(recorder, 1, 0);
  EXPECT_EQ(Rows(table), 5U);
  EXPECT_THAT(Numbers<int32_t>(table, "id"), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(Numbers<uint8_t>(table, "state"), ElementsAre(1, 1, 1, 3, 1));
  EXPECT_THAT(Numbers<uint8_t>(table, "keyframe"), ElementsAre(0, 0, 1, 0, 0));
  EXPECT_FLOAT_EQ(Numbers<float>(table, "t_s").at(4), 0.4F);
  EXPECT_FLOAT_EQ(Numbers<float>(table, "live").at(3 * 2), 1.0F) << "as the map was then";
  EXPECT_FLOAT_EQ(Numbers<float>(table, "odom").at(3 * 2), 0.0F) << "as the session began";
  EXPECT_EQ(Numbers<float>(table, "stages_ms").size(), 10U);
  EXPECT_THAT(Numbers<int32_t>(FrameTable(recorder, 1, 3), "id"), ElementsAre(3, 4));
  EXPECT_THAT(Numbers<int32_t>(FrameTable(recorder, 2, 1), "id"), ElementsAre(2, 4));
  EXPECT_EQ(Rows(FrameTable(Recorder(), 1, 0)), 0U);
}

TEST(FrameTable, LongRunsAreThinnedOut) {
  Recorder recorder;
  FramePose pose = SomePose(0);
  const auto add = [&](size_t n) {
    for (size_t i = 0; i < n; ++i, ++pose.frame_id) recorder.AddPose(pose);
  };
  add(kMaxReportFrames);
  EXPECT_EQ(FrameStride(recorder), 1);
  add(1);
  EXPECT_EQ(FrameStride(recorder), 2);
  add(kMaxReportFrames);
  EXPECT_EQ(FrameStride(recorder), 4);
  EXPECT_EQ(Rows(FrameTable(recorder, 4, 0)), (recorder.frames().size() + 3) / 4);
  EXPECT_EQ(Rows(FrameTable(recorder, 4, 10'000)), 1U);
}

TEST(PathTable, ErrorsAreAfterAlignment) {
  Recorder recorder;
  std::mt19937 random(5);
  const SE3 T_truth_w = Random(random);
  // A curve, and a truth with an error of a centimetre, up and down in turn, in a different frame.
  for (int64_t id = 0; id < 40; ++id) {
    const double angle = 0.15 * static_cast<double>(id);
    FramePose pose = SomePose(id);
    pose.T_odom_c = SE3(ExpSO3({0, angle, 0}), {3.0 * std::sin(angle), 0, 3.0 * std::cos(angle)});
    recorder.AddPose(pose);
    const SE3 off(kUnturned, {0, id % 2 == 0 ? 0.01 : -0.01, 0});
    recorder.AddTruth(FrameId(id), {pose.t_ns, T_truth_w * off * pose.T_odom_c});
  }
  const PathOfRun path = PathTable(recorder, Map(), kUnturned, 1);
  ASSERT_TRUE(path.ate_m);
  EXPECT_NEAR(*path.ate_m, 0.01, 2e-5);
  EXPECT_NEAR(*path.live_ate_m, 0.01, 2e-5);
  EXPECT_EQ(Rows(path.table), 40U);
  const std::vector<float> error_m = Numbers<float>(path.table, "error_m");
  double sum = 0.0;
  for (const float e : error_m) sum += double{e} * double{e};
  EXPECT_NEAR(std::sqrt(sum / 40.0), *path.ate_m, 1e-6);
  EXPECT_LT(Numbers<float>(path.table, "error_deg").at(17), 0.1F);
  EXPECT_NEAR(path.length_m, 39 * 2 * 3.0 * std::sin(0.075), 1e-9);
}

TEST(PathTable, RollOfAStraightPathIsNoError) {
  Recorder recorder;
  for (int64_t id = 0; id < 40; ++id) {
    FramePose pose = SomePose(id);
    const double x = 0.05 * std::sin(0.2 * static_cast<double>(id));
    pose.T_odom_c = SE3(kUnturned, {x, 0, static_cast<double>(id)});
    recorder.AddPose(pose);
    recorder.AddTruth(FrameId(id), {pose.t_ns, SE3(kUnturned, {0, x, static_cast<double>(id)})});
  }
  const PathOfRun path = PathTable(recorder, Map(), kUnturned, 1);
  EXPECT_LT(path.ate_m.value(), 1e-3) << "positions fit after a quarter turn";
  for (const float error_deg : Numbers<float>(path.table, "error_deg")) EXPECT_LT(error_deg, 0.1F);
}

TEST(PathTable, WithoutTruthThereAreNoErrors) {
  Recorder recorder;
  for (int64_t id = 0; id < 3; ++id) recorder.AddPose(SomePose(id));
  const PathOfRun path = PathTable(recorder, Map(), kUnturned, 1);
  EXPECT_FALSE(path.ate_m);
  EXPECT_EQ(FindColumn(path.table, "truth"), nullptr);
  EXPECT_EQ(Rows(PathTable(Recorder(), Map(), kUnturned, 1).table), 0U);
}

TEST(PathTable, FramesWithoutTruthAndLostOnesHaveNone) {
  Recorder recorder;
  for (int64_t id = 0; id < 6; ++id) {
    const FramePose pose = SomePose(id, id == 2 ? TrackingState::kLost : TrackingState::kTracking);
    recorder.AddPose(pose);
    if (id != 4) recorder.AddTruth(FrameId(id), {pose.t_ns, pose.T_odom_c});
  }
  const PathOfRun path = PathTable(recorder, Map(), kUnturned, 1);
  const std::vector<float> error_m = Numbers<float>(path.table, "error_m");
  ASSERT_EQ(error_m.size(), 6U);
  EXPECT_TRUE(std::isnan(error_m[2]));
  EXPECT_TRUE(std::isnan(error_m[4]));
  EXPECT_NEAR(error_m[5], 0.0, 1e-6);
  EXPECT_TRUE(std::isnan(Numbers<float>(path.table, "truth").at(3 * 4)));
}

/// Three keyframes at frames 0, 10, 20; point i is seen by the first 1 + i % 3 of them.
Map SmallMap(int n_points) {
  Map map;
  for (int id = 0; id < 3; ++id) {
    MapKeyframe keyframe;
    keyframe.id = id;
    keyframe.frame_id = FrameId(10 * id);
    keyframe.parent_id = id - 1;
    keyframe.T_w_kf = SE3(kUnturned, {0, 0, 1.0 * static_cast<double>(id)});
    map.Put(keyframe);
  }
  for (int i = 0; i < n_points; ++i) {
    MapPoint point;
    point.id = i;
    point.p_w = {1.0 * i, 2, 3};
    for (int id = 0; id <= i % 3; ++id) point.observations.push_back({id, i});
    map.Put(point);
  }
  MapLine line;
  line.id = 0;
  line.segment_w = {{1, 2, 3}, {4, 5, 6}};
  line.observations = {{1, 0}, {2, 0}};
  map.Put(line);
  map.Add(LoopEdge{.old_keyframe_id = 0, .keyframe_id = 2, .T_old_kf = SE3()});
  map.Add(LoopEdge{.old_keyframe_id = 0, .keyframe_id = 77, .T_old_kf = SE3()});
  return map;
}

TEST(MapTables, HaveTheContentOfTheMap) {
  std::vector<std::string> notes;
  const ReportMap tables = MapTables(SmallMap(60), {}, &notes);
  EXPECT_EQ(Rows(tables.points), 60U);
  EXPECT_THAT(Numbers<float>(tables.segments, "pq"), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(Numbers<int32_t>(tables.segments, "seen"), ElementsAre(10));
  EXPECT_THAT(Numbers<uint16_t>(tables.segments, "life"), ElementsAre(10)) << "from frame 10 to 20";
  EXPECT_THAT(Numbers<uint16_t>(tables.points, "life").at(1), 10);
  EXPECT_THAT(Numbers<uint16_t>(tables.points, "life").at(3), 0) << "one keyframe saw it";
  EXPECT_THAT(Numbers<uint8_t>(tables.segments, "observations"), ElementsAre(2));
  EXPECT_THAT(Numbers<int32_t>(tables.keyframes, "parent"), ElementsAre(-1, 0, 1));
  // 0 and 1 share two of three points, 0 and 2 (as 1 and 2, with the line) a third.
  EXPECT_THAT(Numbers<int32_t>(tables.edges, "ab"), ElementsAre(0, 1, 1, 2, 0, 2));
  EXPECT_THAT(Numbers<int32_t>(tables.edges, "shared"), ElementsAre(40, 21, 20));
  EXPECT_THAT(Numbers<int32_t>(tables.loop_edges, "ab"), ElementsAre(0, 2)) << "keyframe 77 is gone";
  EXPECT_THAT(notes, testing::IsEmpty());
}

TEST(MapTables, LeftOutRowsAreNoted) {
  std::vector<std::string> notes;
  const ReportMap tables = MapTables(SmallMap(60), {.points = 25, .segments = 0, .edges = 1}, &notes);
  EXPECT_EQ(Rows(tables.points), 25U);
  EXPECT_THAT(Numbers<uint8_t>(tables.points, "observations"), testing::Each(testing::Ge(2)))
      << "those seen most often";
  EXPECT_EQ(Rows(tables.segments), 0U);
  EXPECT_THAT(Numbers<int32_t>(tables.edges, "shared"), ElementsAre(40));
  ASSERT_EQ(notes.size(), 3U);
  EXPECT_THAT(notes[0], testing::HasSubstr("25 of 60 points"));
}

/// The numbers that PackObservers wrote, one by one.
std::vector<uint64_t> Unpack(const std::string& bytes) {
  std::vector<uint64_t> numbers;
  uint64_t number = 0;
  int shift = 0;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    number |= static_cast<uint64_t>(byte & 127) << shift;
    shift += 7;
    if (byte >= 128) continue;
    numbers.push_back(number);
    number = 0;
    shift = 0;
  }
  return numbers;
}

TEST(PackObservers, IdsCountsAndRows) {
  MapPoint a, b, c;
  a.id = 3;
  a.observations = {{100, 0}, {101, 0}, {400, 0}};
  b.id = 300;
  b.observations = {{99, 5}, {100, 7}};  // keyframe 99 was removed
  c.id = 301;
  RowOfKeyframe rows{{100, 5}, {101, 6}, {400, 305}};
  EXPECT_THAT(Unpack(PackObservers(std::vector<const MapPoint*>{&a, &b, &c}, rows)),
              ElementsAre(4, 3, 10, 1, 299, 297, 1, 0, 1, 0));
  rows[100] = 2;
  b.observations = {{100, 0}};
  a.observations = {{101, 0}};
  EXPECT_THAT(Unpack(PackObservers(std::vector<const MapPoint*>{&a, &b}, rows)), ElementsAre(4, 1, 12, 297, 1, 7))
      << "back from row 6 to row 2";
}

TEST(PackSigma, StepsOfFivePercent) {
  EXPECT_EQ(PackSigma(0.0), 0);
  EXPECT_EQ(PackSigma(std::nan("")), 0);
  EXPECT_EQ(PackSigma(1e-9), 1);
  EXPECT_EQ(PackSigma(1e9), 255);
  for (const double sigma_m : {0.0002, 0.013, 0.4, 7.0}) {
    EXPECT_NEAR(1e-4 * std::pow(1.05, PackSigma(sigma_m) - 1) / sigma_m, 1.0, 0.026);
  }
}

TEST(MapTables, TooManyObserversAreLeftOut) {
  std::vector<std::string> notes;
  const ReportMap all = MapTables(SmallMap(60), {}, &notes);
  EXPECT_FALSE(all.observers.only_ids);
  EXPECT_THAT(notes, testing::IsEmpty());
  const ReportMap few = MapTables(SmallMap(60), {.observer_bytes = 50}, &notes);
  EXPECT_TRUE(few.observers.only_ids);
  EXPECT_EQ(few.observers.points.size(), 2 * Rows(few.points)) << "the id of each, without observers";
  EXPECT_LT(few.observers.points.size(), all.observers.points.size());
  EXPECT_THAT(notes, ElementsAre(testing::HasSubstr("Observations of landmarks are omitted")));
}

TEST(MapTables, EmptyMap) {
  std::vector<std::string> notes;
  const ReportMap tables = MapTables(Map(), {}, &notes);
  EXPECT_EQ(Rows(tables.points) + Rows(tables.segments) + Rows(tables.keyframes) + Rows(tables.edges), 0U);
}

}  // namespace
}  // namespace plslam::viewer
