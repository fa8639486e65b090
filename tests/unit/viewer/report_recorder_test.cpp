// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/report_recorder.h"

#include <gmock/gmock.h>

#include "core/io/images/jpeg_codec.h"
#include "tests/unit/run/frame_poses.h"
#include "tests/unit/viewer/report_columns.h"

namespace plslam::viewer {
namespace {

using testing::ElementsAre;

const Eigen::Quaterniond kNoTurn = Eigen::Quaterniond::Identity();

MapKeyframe Keyframe(KeyframeId id, double x_m) {
  MapKeyframe keyframe;
  keyframe.id = id;
  keyframe.frame_id = FrameId(10 * id.value);
  keyframe.T_w_kf = SE3(kNoTurn, {x_m, 0, 0});
  return keyframe;
}

/// A map whose owner publishes it, as mapping_process does.
class MapOwner {
 public:
  Map map;

  MapUpdate Next() {
    MapUpdate update = ChangedPart(map, map.TakeChanges());
    update.Follow(version_++);
    return update;
  }

 private:
  int64_t version_ = 0;
};

TEST(CorrectionLog, KeepsPosesOfKeyframesBeforeALoop) {
  MapOwner owner;
  CorrectionLog log;
  for (int id = 0; id < 3; ++id) owner.map.Put(Keyframe(id, 1.0 * static_cast<double>(id)));
  log.Add(owner.Next(), owner.map, 20);
  owner.map.Put(Keyframe(3, 3.0));
  log.Add(owner.Next(), owner.map, 30);
  EXPECT_TRUE(log.corrections().empty()) << "no loop yet";

  const LoopEdge loop{.old_keyframe_id = 0, .keyframe_id = 3, .T_old_kf = SE3()};
  owner.map.Add(loop);
  owner.map.SetPose(3, SE3(kNoTurn, {2.5, 0, 0}), Matrix6d::Zero());
  log.Add(owner.Next(), owner.map, 35);
  ASSERT_EQ(log.corrections().size(), 1U);
  const ReportCorrection& correction = log.corrections()[0];
  EXPECT_EQ(correction.frame_id, 35);
  EXPECT_DOUBLE_EQ(correction.moved_m, 0.5);
  EXPECT_DOUBLE_EQ(log.Moved_m(loop), 0.5);
  EXPECT_THAT(Numbers<int32_t>(correction.table, "keyframe"), ElementsAre(0, 1, 2, 3));
  EXPECT_FLOAT_EQ(Numbers<float>(correction.table, "before").at(9), 3.0F);
  EXPECT_FLOAT_EQ(Numbers<float>(correction.table, "after").at(9), 2.5F);
}

TEST(CorrectionLog, PassedOnLoopIsNoCorrection) {
  MapOwner owner;
  CorrectionLog log;
  for (int id = 0; id < 3; ++id) owner.map.Put(Keyframe(id, 1.0 * static_cast<double>(id)));
  log.Add(owner.Next(), owner.map, 20);
  owner.map.RemoveKeyframe(1);
  owner.map.Put(Keyframe(3, 3.0));
  owner.map.Add(LoopEdge{.old_keyframe_id = 0, .keyframe_id = 2, .T_old_kf = SE3()});
  log.Add(owner.Next(), owner.map, 30);
  EXPECT_TRUE(log.corrections().empty());
}

TEST(CorrectionLog, LateWholeMapIsNoCorrection) {
  MapOwner owner;
  owner.map.Put(Keyframe(0, 0.0));
  owner.map.Put(Keyframe(1, 1.0));
  owner.map.Add(LoopEdge{.old_keyframe_id = 0, .keyframe_id = 1, .T_old_kf = SE3()});
  CorrectionLog log;
  log.Add(WholeMap(owner.map), owner.map, 10);
  log.Add(WholeMap(owner.map), owner.map, 10);
  EXPECT_TRUE(log.corrections().empty());
}

TEST(CorrectionLog, ManyCorrectionsLeaveTheLargest) {
  MapOwner owner;
  CorrectionLog log;
  owner.map.Put(Keyframe(0, 0.0));
  owner.map.Put(Keyframe(1, 0.0));
  log.Add(owner.Next(), owner.map, 0);
  double x_m = 0.0;
  for (int i = 0; i < 100; ++i) {
    x_m += i;
    owner.map.Add(LoopEdge{.old_keyframe_id = 0, .keyframe_id = 1, .T_old_kf = SE3()});
    owner.map.SetPose(1, SE3(kNoTurn, {x_m, 0, 0}), Matrix6d::Zero());
    log.Add(owner.Next(), owner.map, i);
  }
  EXPECT_EQ(log.corrections().size() + static_cast<size_t>(log.dropped()), 100U);
  EXPECT_LE(log.corrections().size(), 50U);
  EXPECT_DOUBLE_EQ(log.corrections().back().moved_m, 99.0);
  EXPECT_GE(log.corrections().front().moved_m, 50.0);
}

TEST(ProcessLog, KeepsQueuesAndRepairsInBoundedMemory) {
  ProcessLog log;
  for (int i = 0; i < 5000; ++i) {
    log.Add({"vo", "running", 100.0 + i, i, 0.5 * i, 40.0, {{"queue.frames", 1.0 * i}, {"frames.sent", 3.0}}});
  }
  log.Add({"vo", "finished", 5200.0, 4999, 2500.0, 40.0, {}});
  const std::vector<ReportProcess> processes = log.Processes();
  ASSERT_EQ(processes.size(), 1U);
  EXPECT_EQ(processes[0].state, "finished");
  EXPECT_LE(Rows(processes[0].table), 601U);
  EXPECT_GE(Rows(processes[0].table), 250U);
  EXPECT_EQ(FindColumn(processes[0].table, "frames.sent"), nullptr);
  const std::vector<float> t_s = Numbers<float>(processes[0].table, "t_s");
  const std::vector<float> queue = Numbers<float>(processes[0].table, "queue.frames");
  EXPECT_FLOAT_EQ(t_s.front(), 0.0F);
  EXPECT_FLOAT_EQ(t_s.back(), 5100.0F) << "a change of state is always kept";
  ASSERT_EQ(queue.size(), t_s.size());
  for (size_t i = 0; i + 1 < t_s.size(); ++i) EXPECT_FLOAT_EQ(queue[i], t_s[i]) << "rows stay together";
  EXPECT_TRUE(std::isnan(queue.back()));
}

TEST(ProcessLog, AnotherProcessOfSameNameIsARestart) {
  ProcessLog log;
  for (const int64_t pid : {40, 40, 57, 57, 58}) {
    ProcessSample sample{"vo", "running", static_cast<double>(pid), 0, 1.0, 1.0, {}};
    sample.pid = pid;
    log.Add(sample);
  }
  ASSERT_EQ(log.Processes().size(), 1U);
  EXPECT_EQ(log.Processes()[0].restarts, 2);
}

TEST(ProcessLog, KeepsTheClockOfTheProcess) {
  ProcessLog log;
  ProcessSample sample{"vo", "running", 5.0, 0, 1.0, 1.0, {}};
  for (const double uptime_s : {3.0, 4.0, static_cast<double>(NAN)}) {
    sample.uptime_s = uptime_s;
    log.Add(sample);
  }
  EXPECT_THAT(Numbers<float>(log.Processes().at(0).table, "uptime_s"), testing::ElementsAre(3.0F, 4.0F));
}

TEST(ProcessLog, LagAndSilenceOfTheLastStatus) {
  ProcessLog log;
  ProcessSample vo{"vo", "running", 0.0, 0, 1.0, 1.0, {}};
  vo.lag_frames = 2;
  vo.sent_frames = 100;
  log.Add(vo);
  log.Add({"recorder", "running", 3.0, 0, 1.0, 1.0, {}});
  ProcessSample mapping{"mapping", "running", 3.0, 0, 1.0, 1.0, {}};
  mapping.queue = 7.0;
  mapping.lag_frames = 40;
  mapping.sent_frames = 160;
  log.Add(mapping);
  const std::vector<ReportProcess> processes = log.Processes();
  ASSERT_EQ(processes.size(), 3U);
  EXPECT_EQ(processes[0].pace, "behind");
  EXPECT_EQ(processes[0].lag_frames, 40);
  EXPECT_DOUBLE_EQ(processes[0].queue, 7.0);
  EXPECT_EQ(processes[1].lag_frames, -1);
  EXPECT_EQ(processes[2].pace, "silent");
  EXPECT_DOUBLE_EQ(processes[2].silent_s, 3.0);
  EXPECT_EQ(processes[2].lag_frames, 62) << "60 frames were sent since";
}

TEST(ProcessLog, InventedProcessesAreHarmless) {
  ProcessLog log;
  for (int i = 0; i < 1000; ++i) {
    ProcessSample sample{"process " + std::to_string(i), "running", 1.0, 0, 1.0, 1.0, {}};
    for (int k = 0; k < 100; ++k) sample.counters.emplace_back("queue." + std::to_string(k), k == 3 ? NAN : 1.0);
    log.Add(sample);
  }
  log.Add({"process 0", "running", NAN, 0, 1.0, 1.0, {}});
  EXPECT_LE(log.Processes().size(), 16U);
  EXPECT_LE(log.Processes()[0].table.size(), 40U);
  EXPECT_EQ(Rows(log.Processes()[0].table), 1U);
}

TEST(MapTimes, RowsHaveTheStagesOfTheirUpdates) {
  MapTimes times;
  MapUpdate update;
  update.version = 1;
  update.stage_ms = {{"insert", 1.0}};
  times.Add(update, 5);
  update = {};
  update.version = 2;
  update.base_version = 1;
  update.stage_ms = {{"adjust", 9.0}, {"insert", 2.0}};
  times.Add(update, 6);
  EXPECT_THAT(times.stage_names(), ElementsAre("insert", "adjust"));
  const Table table = times.Times();
  EXPECT_THAT(Numbers<int32_t>(table, "frame"), ElementsAre(5, 6));
  EXPECT_THAT(Numbers<float>(table, "stages_ms"), ElementsAre(1.0F, testing::IsNan(), 2.0F, 9.0F));
  for (int64_t i = 3; i < 20'000; ++i) {
    update.version = i;
    update.base_version = i - 1;
    times.Add(update, FrameId(i));
  }
  EXPECT_LE(Rows(times.Times()), 4000U);
  EXPECT_EQ(Numbers<int32_t>(times.Times(), "frame").front(), 5);
}

TEST(PictureStore, ThinsOutPicturesBeyondTheLimit) {
  PictureStore store(8);
  const cv::Mat image(120, 1024, CV_8UC1, cv::Scalar(80)), right(120, 1024, CV_8UC1, cv::Scalar(160));
  OverlayFeatures features;
  features.points.push_back({{512.0F, 60.0F}, 4.0F, 2});
  for (int64_t frame = 0; frame < 40; ++frame) {
    if (store.Wants(FrameId(frame))) store.Add(FrameId(frame), image, frame == 0 ? cv::Mat() : right, features, 1024);
  }
  EXPECT_EQ(store.stride(), 8);
  EXPECT_EQ(store.pictures().size(), 5U);
  const ReportPicture& picture = store.pictures().at(32);
  EXPECT_EQ(picture.width_px, 512);
  EXPECT_EQ(picture.height_px, 60);
  EXPECT_FLOAT_EQ(picture.features.points[0].px.x, 256.0F);
  EXPECT_FLOAT_EQ(picture.features.points[0].disparity_px, 4.0F);
  const cv::Mat decoded = DecodeJpeg({reinterpret_cast<const uint8_t*>(picture.jpeg.data()), picture.jpeg.size()},
                                     {picture.width_px, picture.height_px});
  EXPECT_EQ(decoded.cols, 512);
  EXPECT_NEAR(decoded.at<uchar>(30, 256), 80, 3);
  EXPECT_TRUE(store.pictures().at(0).right_jpeg.empty());
  const std::string& jpeg = picture.right_jpeg;
  const cv::Mat right_decoded = DecodeJpeg({reinterpret_cast<const uint8_t*>(jpeg.data()), jpeg.size()}, {256, 30});
  EXPECT_NEAR(right_decoded.at<uchar>(15, 128), 160, 3);
}

TEST(PictureStore, AnnouncedStreamsHaveTheirStrideFromTheStart) {
  PictureStore store(100);
  store.Announce(-1);
  EXPECT_EQ(store.stride(), 1);
  store.Announce(350);
  EXPECT_EQ(store.stride(), 4);
  EXPECT_FALSE(PictureStore(0).Wants(0));
}

TEST(PictureStore, KeyframesStayForLoops) {
  PictureStore store(0);
  const cv::Mat image(48, 64, CV_8UC1, cv::Scalar(80));
  for (int64_t frame = 0; frame < 2500; ++frame) store.AddKeyframe(FrameId(frame), image);
  EXPECT_FALSE(store.Keyframe(0).empty());
  EXPECT_FALSE(store.Keyframe(2499).empty());
  EXPECT_TRUE(store.Keyframe(1).empty()) << "every second one had to go";
  EXPECT_TRUE(store.Keyframe(-1).empty());
}

class ReportRecorderTest : public testing::Test {
 protected:
  void AddFrames(int64_t first, int64_t last) {
    for (int64_t id = first; id <= last; ++id) recorder_.AddPose(SomePose(id));
  }
  ReportData Build(const std::string& since) {
    return report_.Build(recorder_, owner_.map, kNoTurn, *ReportSince::Parse(since));
  }

  Recorder recorder_;
  MapOwner owner_;
  ReportRecorder report_{100};
};

TEST_F(ReportRecorderTest, EmptyReport) {
  const ReportData data = Build("");
  EXPECT_TRUE(data.whole);
  EXPECT_EQ(Rows(data.frames), 0U);
  EXPECT_EQ(data.facts.frames, FrameTally());
  EXPECT_TRUE(data.facts.warnings.empty());
}

TEST_F(ReportRecorderTest, FramesThatFoundNothingAreNotTracked) {
  report_.Begin({"dark", "lockstep", 120});
  for (int64_t id = 0; id < 100; ++id) {
    recorder_.AddPose(SomePose(id, id < 90 ? TrackingState::kInitialising : TrackingState::kTracking));
  }
  report_.Take(1, "frames.dark", 90.0);
  recorder_.SetEnd(110, 10);
  EXPECT_EQ(Build("").facts.frames.tracked_percent(), 9.0) << "ten are on their way";
  report_.Finish();
  const RunFacts facts = Build("").facts;
  EXPECT_EQ(facts.frames.all(), 120);
  EXPECT_EQ(facts.frames.unanswered, 10);
  EXPECT_EQ(facts.frames.tracked_percent(), 8.3);
  ASSERT_EQ(facts.warnings.size(), 3U);
  EXPECT_EQ(facts.warnings[0].code, "little_tracked");
  EXPECT_EQ(facts.warnings[1].code, "dark_images");
  EXPECT_EQ(facts.warnings[2].code, "unreadable_frames");
}

TEST_F(ReportRecorderTest, TruthOfAnotherRunGivesAWarning) {
  // The camera moves 200 m straight on, the truth up and down.
  for (int64_t id = 0; id < 200; ++id) {
    recorder_.AddPose(SomePose(id));
    const double x_m = id % 2 == 0 ? 0.0 : 5.0;
    recorder_.AddTruth(FrameId(id), {SomePose(id).t_ns, SE3(kNoTurn, {x_m, 0.0, 0.0})});
  }
  const ReportData data = Build("");
  EXPECT_THAT(data.notes,
              testing::Contains(testing::HasSubstr("of the roll, positions do not determine it about the path")));
  EXPECT_THAT(data.notes, testing::Contains(testing::StartsWith("Times were measured on ")));
  const RunFacts& facts = data.facts;
  ASSERT_EQ(facts.warnings.size(), 2U);
  EXPECT_EQ(facts.warnings[0].code, "truth_of_another_run");
  EXPECT_EQ(facts.warnings[1].code, "covariance_not_consistent");
  EXPECT_NEAR(facts.warnings[0].numbers[1].second, 2.5, 1e-9);
}

TEST_F(ReportRecorderTest, InconsistentCovariancesGiveAWarning) {
  // Positions are right, and every second orientation is off by half a radian.
  for (int64_t id = 0; id < 50; ++id) {
    FramePose pose = SomePose(id);
    pose.covariance = 1e-8 * static_cast<double>(id) * Matrix6d::Identity();
    recorder_.AddPose(pose);
    const Eigen::Quaterniond q(Eigen::AngleAxisd(id % 2 == 0 ? 0.0 : 0.5, Eigen::Vector3d::UnitY()));
    recorder_.AddTruth(FrameId(id), {pose.t_ns, SE3(q, pose.T_odom_c.translation())});
  }
  const RunFacts facts = Build("").facts;
  ASSERT_EQ(facts.warnings.size(), 1U);
  EXPECT_EQ(facts.warnings[0].code, "covariance_not_consistent");
}

TEST_F(ReportRecorderTest, LivePageGetsOnlyNewData) {
  AddFrames(0, 4);
  owner_.map.Put(Keyframe(0, 0.0));
  report_.Add(owner_.Next(), owner_.map, 4);
  const ReportData first = Build("");
  EXPECT_TRUE(first.whole);
  EXPECT_EQ(Rows(first.frames), 5U);
  ASSERT_TRUE(first.path && first.map);

  AddFrames(5, 6);
  const cv::Mat image(48, 64, CV_8UC1, cv::Scalar(80));
  report_.pictures().Add(5, image, image, {}, image.cols);
  const ReportData second = Build(first.next);
  EXPECT_FALSE(second.whole);
  EXPECT_EQ(second.first_row, 5);
  EXPECT_THAT(Numbers<int32_t>(second.frames, "id"), ElementsAre(5, 6));
  EXPECT_EQ(second.pictures.size(), 1U);
  EXPECT_FALSE(second.path || second.map) << "the map is as it was";

  owner_.map.Put(Keyframe(1, 1.0));
  report_.Add(owner_.Next(), owner_.map, 6);
  const ReportData third = Build(second.next);
  EXPECT_EQ(Rows(third.frames), 0U);
  ASSERT_TRUE(third.path && third.map);
  EXPECT_EQ(Rows(*third.path), 7U) << "of all frames";
  EXPECT_FALSE(Build(third.next).path);
  report_.Finish();
  EXPECT_TRUE(Build(third.next).path) << "once more at the end";
  EXPECT_TRUE(Build(third.next).facts.finished);
}

TEST_F(ReportRecorderTest, SurfacesAreSentIfTheyHaveChanged) {
  SurfaceCloud cloud{0.05, {{0, {1, 0, SE3(), std::vector<SurfacePoint>(5)}}}};
  AddFrames(0, 4);
  report_.SetSurfaces({&cloud, [] { return OccupancyGrid(); }});
  const ReportData first = Build("");
  EXPECT_FALSE(first.surfaces) << "a run without dense_process";
  report_.SurfacesChanged();
  const ReportData second = Build(first.next);
  ASSERT_TRUE(second.surfaces);
  EXPECT_EQ(Rows(second.surfaces->points), 5U);
  EXPECT_FALSE(Build(second.next).surfaces);
  EXPECT_TRUE(Build("").surfaces) << "another page";
}

TEST_F(ReportRecorderTest, AnotherStreamIsSentWhole) {
  AddFrames(0, 4);
  report_ = ReportRecorder(100, 1);
  const ReportData data = Build("0.1.3.0.-1");
  EXPECT_TRUE(data.whole);
  EXPECT_EQ(Rows(data.frames), 5U);
}

TEST_F(ReportRecorderTest, LoopsHaveFramesFiguresAndPictures) {
  AddFrames(0, 30);
  const cv::Mat image(48, 64, CV_8UC1, cv::Scalar(80));
  for (int id = 0; id < 4; ++id) {
    owner_.map.Put(Keyframe(id, 1.0 * static_cast<double>(id)));
    if (id != 3) report_.pictures().AddKeyframe(FrameId(10 * id), image);
  }
  report_.Add(owner_.Next(), owner_.map, 30);
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.edges = {
      {.old_keyframe_id = 0, .keyframe_id = 3, .T_old_kf = SE3(kNoTurn, {3, 4, 0}), .n_points = 80, .n_lines = 9}};
  closure.score = 0.25;
  closure.detect_ms = 2.0;
  closure.correct_ms = 40.0;
  report_.Add(closure);
  owner_.map.Add(closure.edges[0]);
  owner_.map.SetPose(3, SE3(kNoTurn, {2.5, 0, 0}), Matrix6d::Zero());
  report_.Add(owner_.Next(), owner_.map, 30);
  const ReportData data = Build("");
  ASSERT_EQ(data.loops.size(), 1U);
  const ReportLoop& loop = data.loops[0];
  EXPECT_EQ(loop.old_frame_id, 0);
  EXPECT_EQ(loop.frame_id, 30);
  EXPECT_EQ(loop.n_points, 80);
  EXPECT_DOUBLE_EQ(loop.distance_m, 5.0);
  EXPECT_DOUBLE_EQ(loop.score, 0.25);
  EXPECT_DOUBLE_EQ(loop.moved_m, 0.5);
  EXPECT_FALSE(loop.old_jpeg.empty());
  EXPECT_TRUE(loop.jpeg.empty());
  EXPECT_EQ(data.corrections.size(), 1U);
}

TEST_F(ReportRecorderTest, LoopsOfTheLoadedMapAreNotCounted) {
  for (int id = 0; id < 4; ++id) owner_.map.Put(Keyframe(id, 1.0 * static_cast<double>(id)));
  const LoopEdge old{.old_keyframe_id = 0, .keyframe_id = 2, .T_old_kf = SE3()};
  owner_.map.Add(old);
  report_.Add(owner_.Next(), owner_.map, 0);
  EXPECT_EQ(Build("").facts.loops, 0);
  EXPECT_EQ(Build("").loops.size(), 1U) << "the map shows it";
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.keyframe.session = 7;
  closure.keyframe.number = 3;
  closure.edges = {{.old_keyframe_id = 0, .keyframe_id = 3, .T_old_kf = SE3()}};
  report_.Add(closure);
  report_.Add(closure);
  EXPECT_EQ(Build("").facts.loops, 1) << "said again";
  closure.kind = LoopClosure::Kind::kAdjustment;
  closure.keyframe.number = 4;
  report_.Add(closure);
  EXPECT_EQ(Build("").facts.loops, 1) << "an adjustment is no loop";
}

}  // namespace
}  // namespace plslam::viewer
