// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "core/files/atomic_file.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/http_client.h"
#include "tests/support/shell.h"
#include "tests/support/text_file.h"
#include "viewer_headless/report/report_json.h"
#include "viewer_headless/report/report_page.h"
#include "viewer_headless/report/report_recorder.h"

namespace plslam::viewer {
namespace {

using test::WholeRun;

/// Returns a program in PATH; empty if there is none.
std::string Find(const std::string& program) {
  std::istringstream path(getenv("PATH") != nullptr ? getenv("PATH") : "");
  for (std::string folder; std::getline(path, folder, ':');) {
    if (access((folder + "/" + program).c_str(), X_OK) == 0) return folder + "/" + program;
  }
  return "";
}

/// Returns the reason why the pages cannot be tested here; empty if they can.
std::string Missing() {
  for (const char* program : {"node", "chromium", "chromedriver"}) {
    if (Find(program).empty()) return std::string("no ") + program + " here: the page of reports is not tested";
  }
  if (!std::filesystem::exists(test::BinaryFolder().parent_path() / "share/plslam/report_template.html")) {
    return "built without node and npm: there are no reports";
  }
  return "";
}

std::string Script(const std::string& name) { return (test::SourceFolder() / "tests/report" / name).string(); }

/// A script run by node, whose output is written to `log`.
class NodeScript {
 public:
  NodeScript(const std::vector<std::string>& arguments, std::filesystem::path log)
      : log_(std::move(log)), process_(Find("node"), arguments, log_) {}

  /// Waits until it prints `text`, or has exited.
  void WaitUntilItSays(const std::string& text) {
    WaitFor([&] { return process_.Poll().has_value() || Text().find(text) != std::string::npos; });
  }
  /// Waits for its regular exit, and prints its output.
  void Finish() {
    WaitFor([&] { return process_.Poll().has_value(); });
    ASSERT_TRUE(process_.Poll().has_value()) << "not ended after five minutes\n" << Text();
    std::printf("%s", Text().c_str());
    EXPECT_EQ(process_.Poll()->code, 0) << "what failed stands above";
  }

 private:
  /// Five minutes: drawing the map without a graphics card takes long where others are at work.
  template <class Condition>
  static void WaitFor(Condition condition) {
    for (int minute = 0; minute < 5 && !WholeRun::WaitFor(condition); ++minute) {
    }
  }
  std::string Text() const {
    std::ifstream file(log_);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  std::filesystem::path log_;
  launcher::ChildProcess process_;
};

/// Returns the arguments of a script that drives a browser.
std::vector<std::string> BrowserArguments(const std::string& script, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {Script(script), Find("chromedriver"), Find("chromium")});
  return arguments;
}

void RunScript(const std::string& script, const std::vector<std::string>& arguments,
               const std::filesystem::path& log) {
  NodeScript(BrowserArguments(script, arguments), log).Finish();
}

/// Checks that the scripts check_NAME.mjs find no fault in the report of the run.
void CheckReport(const WholeRun& run, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    RunScript("check_" + name + ".mjs", {(run.out() / "report.html").string()}, run.folder() / (name + ".log"));
  }
}

TEST(Report, PageAssemblesLiveData) {
  if (Find("node").empty()) GTEST_SKIP() << "no node here: the page of reports is not tested";
  const std::string log = testing::TempDir() + "data_test " + std::to_string(getpid());
  NodeScript({"--test", Script("data_test.mjs"), Script("live_test.mjs"), Script("orders_test.mjs")}, log).Finish();
  std::filesystem::remove(log);
}

TEST(Report, LivePageThenReportFile) {
  if (const std::string why = Missing(); !why.empty()) GTEST_SKIP() << why;
  WholeRun run;
  const std::string port = std::to_string(test::FreePort());
  // Longer than the page is watched.
  run.Start(
      {"run", "synthetic:room?frames=5000&size=376x240", "--pace", "realtime", "--set", "viewer.serve=" + port});
  ASSERT_TRUE(WholeRun::WaitFor([&] { return run.Logs().find("live page: ") != std::string::npos; })) << run.Logs();
  NodeScript page(
      BrowserArguments("check_live.mjs", {"http://127.0.0.1:" + port + "/", std::to_string(run.PidOf("vo_process"))}),
      run.folder() / "live.log");
  page.WaitUntilItSays("watching\n");
  run.process().Signal(SIGINT);
  ASSERT_NE(run.Wait(60), -1) << run.Logs();
  page.Finish();
  ASSERT_TRUE(std::filesystem::exists(run.out() / "report.html")) << run.Logs();
  EXPECT_LT(std::filesystem::file_size(run.out() / "report.html"), 8'000'000U);
  CheckReport(run, {"report", "picture"});
}

TEST(Report, IsUsedWithMouseAndKeys) {
  if (const std::string why = Missing(); !why.empty()) GTEST_SKIP() << why;
  WholeRun run;
  // Once around, with a loop.
  ASSERT_EQ(run.Run({"run", "synthetic:room?frames=400&size=376x240"}), 0) << run.Logs();
  CheckReport(run, {"use", "link"});
}

TEST(Report, ShowsARefinedMap) {
  if (const std::string why = Missing(); !why.empty()) GTEST_SKIP() << why;
  WholeRun run;
  ASSERT_EQ(run.Run({"run", "synthetic:room?frames=60&size=376x240", "--refine", "fixed"}), 0) << run.Logs();
  CheckReport(run, {"refinement"});
}

TEST(Report, ShowsSurfacesAndGrid) {
  if (const std::string why = Missing(); !why.empty()) GTEST_SKIP() << why;
  if (!std::filesystem::exists(test::BinaryFolder() / "dense_process")) GTEST_SKIP() << "built without OpenVDB";
  WholeRun run;
  ASSERT_EQ(run.Run({"run", "synthetic:room?frames=160&size=376x240", "--dense"}), 0) << run.Logs();
  CheckReport(run, {"surfaces"});
}

TEST(Report, MapsOfTwoRunsTogether) {
  if (const std::string why = Missing(); !why.empty()) GTEST_SKIP() << why;
  WholeRun both, points;
  const std::string world = "synthetic:room?frames=60&size=376x240";
  ASSERT_EQ(both.Run({"run", world}), 0) << both.Logs();
  ASSERT_EQ(points.Run({"run", world, "--features", "points"}), 0) << points.Logs();
  const ScratchFolder folder;
  std::filesystem::create_directory(folder.Path("maps"));
  const auto compare = [&](const std::filesystem::path& other) {
    return test::Shell(folder, "'" + (test::BinaryFolder() / "evaluate").string() + "' compare '" +
                                   both.out().string() + "' '" + other.string() + "' --html '" +
                                   folder.Path("maps/../all runs.html") + "' --map '" +
                                   folder.Path("maps/page.html") + "'");
  };
  const test::ShellResult done = compare(points.out());
  ASSERT_EQ(done.exit_code, 0) << done.error;
  RunScript("check_joint.mjs", {folder.Path("maps/page.html")}, folder.Path("joint.log"));
  const test::ShellResult alone = compare(folder.Path(""));
  EXPECT_EQ(alone.exit_code, 1);
  const std::string html = ReadText(folder.Path("all runs.html"));
  EXPECT_EQ(html.find("page.html"), std::string::npos) << "a link to a map that could not be made";
  EXPECT_NE(alone.error.find("no other run used the dataset of "), std::string::npos) << alone.error;
}

/// A drive of half a kilometre along a wavy road that returns to its start, with a given number of landmarks, and a
/// loop at the end.
class BigRun {
 public:
  BigRun(int64_t n_points, int64_t n_segments) : random_(7) {
    for (int64_t id = 0; id < kFrames; ++id) AddFrame(id);
    for (int64_t id = 0; id < kKeyframes; ++id) map_.Put(Keyframe(id, 1.0));
    for (int64_t id = 0; id < n_points; ++id) AddPoint(id);
    for (int64_t id = 0; id < n_segments; ++id) AddSegment(id);
    map_.TakeChanges();
    MapUpdate update = WholeMap(map_);
    update.version = 1;
    report_.Add(update, map_, FrameId(kFrames));
    Close();
    report_.Finish();
  }

  std::string Json() const {
    return ReportJson(report_.Build(recorder_, map_, Eigen::Quaterniond::Identity(), ReportSince()));
  }

 private:
  static constexpr int64_t kFrames = 2000;
  static constexpr int64_t kKeyframes = 400;

  /// Frame `id`, with a share of the drift that the loop removes.
  static SE3 Pose(int64_t id, double drift) {
    const double share = static_cast<double>(id) / static_cast<double>(kFrames);
    const double angle = 2.0 * M_PI * share;
    const double radius = 80.0 + 10.0 * std::sin(5.0 * angle) + 8.0 * drift * share;
    return SE3(ExpSO3({0, angle, 0}),
               {radius * std::sin(angle), 2.0 * std::sin(2.0 * angle), radius * std::cos(angle)});
  }

  void AddFrame(int64_t id) {
    FramePose pose;
    pose.frame_id = FrameId(id);
    pose.t_ns = id * 100'000'000;
    pose.state = TrackingState::kTracking;
    pose.T_odom_c = Pose(id, 1.0);
    pose.keyframe_id = id % 5 == 0 ? id / 5 : -1;
    pose.entropy_ratio = 1.0;
    pose.counts = {900, 120, 400, 60, 0};
    pose.stages_ms = {{"features", 9.0}, {"track", 3.0}};
    recorder_.AddPose(pose);
    recorder_.AddTruth(FrameId(id), {pose.t_ns, Pose(id, 0.0)});
  }

  static MapKeyframe Keyframe(int64_t id, double drift) {
    MapKeyframe keyframe;
    keyframe.id = KeyframeId(id);
    keyframe.name.number = id;
    keyframe.frame_id = FrameId(5 * id);
    keyframe.parent_id = KeyframeId(id - 1);
    keyframe.T_w_kf = Pose(5 * id, drift);
    keyframe.T_odom_kf = Pose(5 * id, 1.0);
    return keyframe;
  }

  Eigen::Vector3d Near(int64_t keyframe_id) {
    std::normal_distribution<double> normal;
    return Pose(5 * keyframe_id, 0.0) * Eigen::Vector3d{8.0 * normal(random_), 2.0 * normal(random_), 8.0};
  }

  std::vector<Observation> Observations(int64_t keyframe_id, int64_t id) {
    std::vector<Observation> observations;
    for (int64_t k = keyframe_id; k < std::min(kKeyframes, keyframe_id + 2 + id % 9); ++k) {
      observations.push_back({KeyframeId(k), feature_[static_cast<size_t>(k)]++});
    }
    return observations;
  }

  void AddPoint(int64_t id) {
    MapPoint point;
    point.id = LandmarkId(id);
    point.p_w = Near(id % kKeyframes);
    point.observations = Observations(id % kKeyframes, id);
    map_.Put(point);
  }

  void AddSegment(int64_t id) {
    MapLine line;
    line.id = LandmarkId(id);
    line.segment_w.p = Near(id % kKeyframes);
    line.segment_w.q = line.segment_w.p + Eigen::Vector3d(0, id % 3 == 0 ? 0 : 2.5, id % 3 == 0 ? 1.5 : 0);
    const std::vector<Observation> observations = Observations(id % kKeyframes, id);
    line.observations = observations;
    map_.Put(line);
  }

  void Close() {
    map_.Add(LoopEdge{.old_keyframe_id = 0,
                      .keyframe_id = KeyframeId(kKeyframes - 1),
                      .T_old_kf = SE3(),
                      .n_points = 90,
                      .n_lines = 12});
    for (int64_t id = 0; id < kKeyframes; ++id) map_.SetPose(KeyframeId(id), Pose(5 * id, 0.0), Matrix6d::Zero());
    MapUpdate update = ChangedPart(map_, map_.TakeChanges());
    update.version = 2;
    update.base_version = 1;
    report_.Add(update, map_, FrameId(kFrames - 1));
  }

  std::mt19937 random_;
  std::vector<int32_t> feature_ = std::vector<int32_t>(kKeyframes, 0);
  Recorder recorder_;
  Map map_;
  ReportRecorder report_{0};
};

TEST(Report, AHundredThousandPointsStayFluid) {
  if (const std::string why = Missing(); !why.empty()) GTEST_SKIP() << why;
  const auto page = ReadReportTemplate();
  ASSERT_TRUE(page) << "it should stand beside this program too";
  const std::string folder = testing::TempDir() + "big report " + std::to_string(getpid());
  std::filesystem::create_directories(folder);
  const std::string file = folder + "/report.html";
  WriteFileAtomically(file, FillTemplate(*page, BigRun(100'000, 10'000).Json()));
  std::printf("     %.1f MB\n", 1e-6 * static_cast<double>(std::filesystem::file_size(file)));
  EXPECT_LT(std::filesystem::file_size(file), 8'000'000U);
  RunScript("check_report.mjs", {file, "fluid"}, folder + "/report.log");
  if (!HasFailure()) std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace plslam::viewer
