// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <string>

#include "core/bus/channels.h"
#include "core/bus/logs/log_reader.h"
#include "core/bus/transport/wire.h"
#include "core/datasets/open_dataset.h"
#include "core/io/images/png_codec.h"
#include "core/io/trajectories/trajectory.h"
#include "plslam/tracks_t.hpp"
#include "tests/integration/image_folder_of.h"
#include "tests/integration/recorded_run.h"
#include "tests/integration/whole_run.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

using test::ReadRecordedRun;
using test::RecordedRun;
using test::WholeRun;

constexpr int kFrames = 60;
const std::string kWorld = "synthetic:room?frames=60&size=376x240";

long Lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

void ExpectAllExitedCleanly(const nlohmann::json& summary) {
  for (const auto& [name, process] : summary["processes"].items()) {
    EXPECT_EQ(process["exit_code"], 0) << name;
    EXPECT_EQ(process["restarts"], 0) << name;
  }
}

/// Checks that every frame was sent and answered, once and in order.
void ExpectWholeLog(const RecordedRun& log, int frames) {
  EXPECT_EQ(log.Count("POSE"), frames);
  EXPECT_EQ(log.Count("GROUND_TRUTH"), frames);
  EXPECT_GE(log.Count("STEREO_FRAME"), 2 * frames);
  EXPECT_GE(log.Count("KEYFRAME"), 1);
  EXPECT_GE(log.Count("CAMERA"), 1);
  for (const char* channel : {"POSE", "KEYFRAME", "STREAM"}) EXPECT_EQ(log.Gaps(channel), 0) << channel;
  ASSERT_EQ(log.streams.size(), 2U);
  EXPECT_EQ(log.streams[0].event, "begin");
  EXPECT_EQ(log.streams[1].event, "end");
  EXPECT_EQ(log.streams[1].n_frames, frames);
  EXPECT_EQ(log.undecodable, 0);
}

/// The summary, the files and the log describe the same map.
void ExpectMap(const WholeRun& run, const RecordedRun& log, const nlohmann::json& summary) {
  EXPECT_GE(log.map_totals.keyframes, 2);
  EXPECT_EQ(summary["map"]["keyframes"], log.map_totals.keyframes);
  EXPECT_EQ(summary["landmarks"]["points"], log.map_totals.points);
  EXPECT_EQ(summary["landmarks"]["lines"], log.map_totals.lines);
  EXPECT_GE(summary["map"]["observations_per_point"], 1.0);
  EXPECT_GT(summary["map"]["adjustment_ms"]["median"], 0.0) << summary["map"].dump(1);
  EXPECT_EQ(Lines(run.Read("keyframes.tum")), log.map_totals.keyframes);
  const std::string n = std::to_string(log.map_totals.points + 2 * log.map_totals.lines);
  EXPECT_NE(run.Read("map.ply").find("\nelement vertex " + n + "\n"), std::string::npos);
}

TEST(Run, LockstepOnASyntheticWorld) {
  WholeRun run;
  ASSERT_EQ(run.Run({"run", kWorld, "--record", run.log()}), 0) << run.Logs();
  const RecordedRun log = ReadRecordedRun(run.log());
  ExpectWholeLog(log, kFrames);

  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["frames"], kFrames) << summary.dump(1);
  EXPECT_EQ(summary["tracked_frames"], kFrames);
  EXPECT_GE(summary["keyframes"], 1);
  EXPECT_GT(summary["landmarks"]["points"], 20);
  EXPECT_GT(summary["landmarks"]["lines"], 5);
  EXPECT_EQ(summary["messages"]["rejected"], 0);
  EXPECT_LT(summary["accuracy"]["ate_m"], 0.03) << summary["accuracy"].dump(1);
  EXPECT_GT(summary["stage_ms"].size(), 2U);
  EXPECT_TRUE(summary["configuration"]["vo"]["vo"].is_object()) << summary["configuration"].dump(1);
  ExpectAllExitedCleanly(summary);
  EXPECT_EQ(Lines(run.Read("trajectory.tum")), kFrames);
  EXPECT_EQ(Lines(run.Read("trajectory_live.tum")), kFrames);
  ExpectMap(run, log, summary);
}

TEST(Run, WithoutMapping) {
  WholeRun run;
  ASSERT_EQ(run.Run({"run", kWorld, "--no-mapping", "--record", run.log()}), 0) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["tracked_frames"], kFrames);
  EXPECT_FALSE(summary["processes"].contains("mapping"));
  EXPECT_TRUE(summary["map"].is_null());
  EXPECT_GT(summary["landmarks"]["points"], 20);
  EXPECT_EQ(ReadRecordedRun(run.log()).Count("MAP_UPDATE"), 0);
  EXPECT_FALSE(std::filesystem::exists(run.out() / "map.ply"));
  EXPECT_EQ(run.Read("trajectory.tum"), run.Read("trajectory_live.tum"));
  EXPECT_EQ(Lines(run.Read("keyframes.tum")), summary["keyframes"]);
}

/// Features of all frames of a recorded run.
std::vector<tracks_t> TracksOf(const std::string& log) {
  bus::LogReader reader(log);
  std::vector<tracks_t> tracks;
  while (const auto event = reader.Next()) {
    if (event->channel != bus::kTracks.name) continue;
    const auto message = bus::Decoded<tracks_t>(*reader.Data(event->data_offset, event->data_bytes));
    if (message) tracks.push_back(*message);
  }
  return tracks;
}

TEST(Run, MoreFeaturesThanFitAMessage) {
  WholeRun run;
  ASSERT_EQ(run.Run({"run", "synthetic:room?frames=4&noise=30", "--set", "vo.features.orb.max_points=6000", "--set",
                     "vo.features.orb.fast_threshold=2", "--set", "vo.features.orb.min_fast_threshold=2", "--record",
                     run.log()}),
            0)
      << run.Logs();
  EXPECT_EQ(run.Summary()["tracked_frames"], 4);
  EXPECT_EQ(run.Summary()["processes"]["vo"]["restarts"], 0);
  const std::vector<tracks_t> tracks = TracksOf(run.log());
  ASSERT_EQ(tracks.size(), 4U);
  EXPECT_GT(tracks.back().points.size(), 2000U);
  EXPECT_LT(tracks.back().getEncodedSize(), 60000);
}

TEST(Run, MaskedPartHasNoFeaturesInRunAndReplay) {
  constexpr int kMaskedFrom = 170;
  WholeRun run, again, unmasked;
  cv::Mat mask(240, 376, CV_8UC1, cv::Scalar(255));
  mask.rowRange(kMaskedFrom, 240).setTo(0);
  const std::string file = (run.folder() / "mask.png").string(), map = (run.folder() / "a.plmap").string();
  WritePng(file, mask);
  ASSERT_EQ(run.Run({"run", kWorld, "--record", run.log(), "--save-map", map, "--set", "player.mask_left=" + file,
                     "--set", "player.mask_right=" + file}),
            0)
      << run.Logs();
  ASSERT_EQ(again.Run({"run", run.log(), "--record", again.log()}), 0) << again.Logs();
  for (const WholeRun* one : {&run, &again}) {
    const std::vector<tracks_t> tracks = TracksOf(one->log());
    EXPECT_GE(tracks.size(), static_cast<size_t>(kFrames));
    for (const tracks_t& frame : tracks) {
      EXPECT_GT(frame.points.size(), 30U) << frame.frame_id;
      for (const track_point_t& point : frame.points) EXPECT_LT(point.v_px, kMaskedFrom) << frame.frame_id;
      for (const track_line_t& line : frame.lines) EXPECT_LT(std::max(line.p_px[1], line.q_px[1]), kMaskedFrom);
    }
    EXPECT_EQ(one->Summary()["tracked_frames"], kFrames);
    EXPECT_LT(one->Summary()["accuracy"]["ate_m"], 0.03);
  }
  EXPECT_EQ(run.Read("trajectory.tum"), again.Read("trajectory.tum"));
  EXPECT_EQ(unmasked.Run({"run", kWorld, "--map", map}), 0) << unmasked.Logs();
}

TEST(Run, ReplayOfTheRecordedLogGivesTheSameBits) {
  WholeRun live, replay;
  ASSERT_EQ(live.Run({"run", kWorld, "--record", live.log()}), 0) << live.Logs();
  replay.Start({"replay", live.log()});
  ASSERT_EQ(replay.Wait(), 0) << replay.Logs();
  EXPECT_EQ(Lines(live.Read("trajectory.tum")), kFrames);
  EXPECT_EQ(live.Read("trajectory.tum"), replay.Read("trajectory.tum"));
  EXPECT_EQ(live.Read("keyframes.tum"), replay.Read("keyframes.tum"));
  EXPECT_TRUE(live.Read("map.ply") == replay.Read("map.ply"));
  EXPECT_EQ(live.Summary()["accuracy"]["ate_m"], replay.Summary()["accuracy"]["ate_m"]);
}

TEST(Run, FivePercentLossIsRepaired) {
  WholeRun whole, lossy;
  ASSERT_EQ(whole.Run({"run", kWorld}), 0) << whole.Logs();
  ASSERT_EQ(lossy.Run({"run", kWorld, "--record", lossy.log(), "--set", "bus.drop_fraction=0.05"}), 0)
      << lossy.Logs();
  ExpectWholeLog(ReadRecordedRun(lossy.log()), kFrames);
  const nlohmann::json summary = lossy.Summary();
  EXPECT_GT(summary["messages"]["lost"], 0) << "nothing was dropped";
  EXPECT_GT(summary["messages"]["repaired"], 0);
  EXPECT_EQ(summary["tracked_frames"], kFrames);
  EXPECT_EQ(whole.Read("trajectory.tum"), lossy.Read("trajectory.tum"));
  EXPECT_TRUE(whole.Read("map.ply") == lossy.Read("map.ply"));
}

TEST(Run, RelayInsteadOfMulticast) {
  WholeRun relay, run;
  relay.Start({"relay", "--port", "0"});
  const auto address = [&] {
    const std::string log = relay.Logs();
    const size_t at = log.find("tcpq://");
    const size_t end = at == std::string::npos ? at : log.find('\n', at);
    return end == std::string::npos ? std::string() : log.substr(at, end - at);
  };
  ASSERT_TRUE(WholeRun::WaitFor([&] { return !address().empty(); })) << relay.Logs();
  ASSERT_EQ(run.Run({"run", kWorld, "--url", address()}), 0) << run.Logs();
  EXPECT_EQ(run.Summary()["tracked_frames"], kFrames);
  relay.process().Signal(SIGINT);
  EXPECT_EQ(relay.Wait(), 0);
}

/// 30 frames of a room as a folder of images, the lens covered in the first `n_covered` of them.
void WriteImages(const std::filesystem::path& folder, int n_covered) {
  const auto world = OpenDataset("synthetic:room?frames=30&size=376x240", "");
  std::vector<test::ChosenFrame> frames;
  for (int i = 0; i < world->size(); ++i) frames.push_back({i, i < n_covered});
  test::WriteImageFolder(*world, frames, folder);
}

std::vector<std::string> WarningsOf(const nlohmann::json& summary) {
  std::vector<std::string> codes;
  for (const nlohmann::json& warning : summary["warnings"]) codes.push_back(warning["code"]);
  return codes;
}

/// Returns the warnings in the page, whatever the viewer has written.
nlohmann::json WarningsOfReport(const WholeRun& run) {
  const std::string page = run.Read("report.html"), begin = R"(<script id="run-warnings" type="application/json">)";
  const size_t at = page.find(begin) + begin.size();
  return nlohmann::json::parse(page.substr(at, page.find("</script>", at) - at));
}

TEST(Run, RunWithFewTrackedFramesGivesWarnings) {
  WholeRun run;
  const std::filesystem::path images = run.folder() / "images";
  WriteImages(images, 27);
  ASSERT_EQ(run.Run({"run", images.string(), "--strict"}), 2) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["tracked_percent"], 10.0);
  EXPECT_EQ(summary["initialising_frames"], 27);
  EXPECT_THAT(WarningsOf(summary), testing::ElementsAre("little_tracked", "dark_images"));
  for (const nlohmann::json& warning : summary["warnings"]) {
    EXPECT_THAT(run.Logs(), testing::HasSubstr("plslam: warning: " + warning["sentence"].get<std::string>()));
  }
  if (!std::filesystem::exists(run.out() / "report.html")) return;  // built without node
  const std::string report = run.Read("report.html");
  EXPECT_NE(report.find("\"tracked_percent\":10.0"), std::string::npos);
  EXPECT_EQ(WarningsOfReport(run), summary["warnings"]);
}

TEST(Run, ReportHasTheWarningsOfTheSummary) {
  WholeRun run;
  const std::filesystem::path images = run.folder() / "images";
  WriteImages(images, 0);
  // Positions stay, so that the path is right, and every second true pose is turned by half a radian.
  Trajectory truth = ReadTrajectory(images / "groundtruth.txt", TrajectoryFormat::kTum);
  const SE3 turn = SE3::Exp((Vector6d() << 0, 0, 0, 0, 0.5, 0).finished());
  for (size_t i = 1; i < truth.size(); i += 2) truth[i].T_a_b = truth[i].T_a_b * turn;
  WriteTrajectory(images / "groundtruth.txt", TrajectoryFormat::kTum, truth);
  ASSERT_EQ(run.Run({"run", images.string()}), 0) << run.Logs();
  EXPECT_THAT(WarningsOf(run.Summary()), testing::ElementsAre("covariance_not_consistent"));
  if (!std::filesystem::exists(run.out() / "report.html")) return;  // built without node
  EXPECT_EQ(WarningsOfReport(run), run.Summary()["warnings"]);
  EXPECT_NE(run.Read("report.html").find("\"code\":\"covariance_not_consistent\""), std::string::npos)
      << "the viewer knows it, too";
}

TEST(Run, ExchangedImagesAreReported) {
  WholeRun run;
  const std::filesystem::path images = run.folder() / "images";
  WriteImages(images, 0);
  std::filesystem::rename(images / "left", images / "exchanged");
  std::filesystem::rename(images / "right", images / "left");
  std::filesystem::rename(images / "exchanged", images / "right");
  ASSERT_EQ(run.Run({"run", images.string()}), 0) << run.Logs();
  EXPECT_THAT(WarningsOf(run.Summary()), testing::Contains("few_stereo_matches"));
  EXPECT_THAT(run.Logs(), testing::HasSubstr("check with `plslam rectify-check '" + images.string() + "'`"));
}

/// One and two frames have no path, no aligned truth and hardly a map; small images have no features.
class FewFrames : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Worlds, FewFrames,
                         testing::Values("synthetic:room?frames=1&size=376x240",
                                         "synthetic:room?frames=2&size=376x240",
                                         "synthetic:whitewall?frames=4&size=64x48"));

TEST_P(FewFrames, NoFileContainsNaN) {
  WholeRun run;
  run.Run({"run", GetParam()});
  const std::regex not_a_number("[-+ ,:;\\[\\t\"](nan|NaN|inf|Infinity)\\b");
  int n_files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(run.out())) {
    static const std::set<std::string> kText = {".csv", ".json", ".ply", ".tum", ".txt", ".yaml"};
    if (!kText.contains(entry.path().extension().string())) continue;
    const std::string text = ReadText(entry.path());
    std::smatch found;
    EXPECT_FALSE(std::regex_search(text, found, not_a_number)) << entry.path() << ": ..." << found.str();
    ++n_files;
  }
  EXPECT_GE(n_files, 5) << run.Logs();
}

}  // namespace
}  // namespace plslam
