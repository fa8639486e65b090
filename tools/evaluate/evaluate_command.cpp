// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/evaluate_commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "core/errors/standard_streams.h"
#include "core/files/atomic_file.h"
#include "core/process/choice_argument.h"
#include "plslam_version.h"
#include "tools/command_line/run_command_line.h"
#include "tools/evaluate/accuracy.h"
#include "tools/evaluate/figures/accuracy_figure.h"

namespace plslam::evaluate {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string estimate;
  std::optional<TrajectoryFormat> estimate_format;
  std::string truth;
  std::optional<TrajectoryFormat> truth_format;
  std::string times;
  Alignment align = Alignment::kSe3;
  double max_difference_s = 0.02;
  bool interpolate = false;
  double max_gap_s = 0.5;
  std::vector<std::string> deltas{"1f", "1s", "1m"};
  int64_t frames = 0;
  std::string keyframes;
  std::string covariance;
  std::string motion_covariance;
  double clock_s = 0.0;
  std::string json;
  std::string plot;
};

void AddOptions(CLI::App& app, Arguments& a) {
  app.add_option("estimate", a.estimate, "estimated trajectory (TUM, KITTI or EuRoC format)")->required();
  app.add_option("--truth", a.truth, "true trajectory, in any of these formats")->required();
  AddChoice(&app, "--estimate-format", a.estimate_format, "format of the estimate [recognised from its content]");
  AddChoice(&app, "--truth-format", a.truth_format, "format of the truth [recognised from its content]");
  app.add_option("--times", a.times, "times of trajectories in KITTI format, one value in seconds per line");
  AddChoice(&app, "--align", a.align, "alignment: none, first, se3 or sim3");
  app.add_option("--max-difference", a.max_difference_s, "largest time difference of two poses, in seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_flag("--interpolate", a.interpolate, "interpolate the truth instead of taking the nearest pose");
  app.add_option("--max-gap", a.max_gap_s, "largest gap of the truth to interpolate across, in seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--delta", a.deltas, "intervals of the relative error: 5f, 1s, 2.5m ...")->default_str("1f 1s 1m");
  app.add_option("--frames", a.frames, "frames of the sequence, for the coverage [the number of true poses]")
      ->check(CLI::Range(int64_t{0}, int64_t{1} << 40));
  app.add_option("--keyframes", a.keyframes, "trajectory of the keyframes only: errors between keyframes");
  app.add_option("--covariance", a.covariance, "covariances of the poses (covariance.txt of the viewer): NEES");
  app.add_option("--motion-covariance", a.motion_covariance, "covariances of the motions: NEES");
  app.add_option("--clock", a.clock_s, "search for an offset of the clocks up to this, in seconds")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  app.add_option("--json", a.json, "write all numbers to this file");
  app.add_option("--plot", a.plot, "draw the paths and errors into this file: .svg, .pdf or .png");
  app.set_version_flag("--version", PLSLAM_VERSION);
}

/// Reads a file and prints its notes. All rows of an estimate must be valid.
TrajectoryFile Read(const std::string& path, std::optional<TrajectoryFormat> format, const std::string& times,
                    BadRows bad_rows) {
  TrajectoryFile file = ReadTrajectoryFile(path, format, bad_rows, times);
  if (file.poses.empty() && file.n_rows > 0) throw std::runtime_error(file.notes.warnings.back());
  for (const std::string& warning : file.notes.warnings) PrintError("evaluate: warning: " + warning);
  for (const std::string& remark : file.notes.remarks) PrintError("evaluate: note: " + remark);
  return file;
}

bool HasNoTimes(const TrajectoryFile& file, const Arguments& a) {
  return a.times.empty() && file.format == TrajectoryFormat::kKitti;
}

/// Frame numbers used as seconds are no clock times: no poses, or by chance wrong ones, would be associated. And if two
/// such files differ in length, rows of the same number are not of the same frame: a frame without a pose has none.
void CheckTimes(const Arguments& a, const TrajectoryFile& estimate, const TrajectoryFile& truth) {
  const bool estimate_lacks = HasNoTimes(estimate, a);
  if (estimate_lacks != HasNoTimes(truth, a)) {
    throw std::runtime_error(
        fmt::format("{}: has no times because it is in KITTI format, but {} has: give --times FILE",
                    estimate_lacks ? a.estimate : a.truth, estimate_lacks ? a.truth : a.estimate));
  }
  if (!estimate_lacks || estimate.n_rows == truth.n_rows) return;
  throw std::runtime_error(fmt::format(
      "{} has {} poses and {} has {}, without times because of the KITTI format, so that they cannot be associated: "
      "give the estimate with its times (trajectory.tum of a run), and --times FILE for the truth",
      a.estimate, estimate.n_rows, a.truth, truth.n_rows));
}

int64_t ToNs(double seconds) { return std::llround(1e9 * seconds); }

EvaluateOptions ToOptions(const Arguments& a) {
  EvaluateOptions options;
  options.alignment = a.align;
  options.max_difference_ns = ToNs(a.max_difference_s);
  options.interpolate_truth = a.interpolate;
  options.max_gap_ns = ToNs(a.max_gap_s);
  options.n_frames = a.frames;
  options.max_clock_offset_s = a.clock_s;
  options.deltas.clear();
  for (const std::string& delta : a.deltas) options.deltas.push_back(DeltaFromText(delta));
  if (!a.keyframes.empty()) {
    for (const TrajectoryPose& pose : ReadTrajectory(a.keyframes, a.times))
      options.keyframe_t_ns.push_back(pose.t_ns);
  }
  if (!a.covariance.empty()) options.covariances = ReadPoseCovariances(a.covariance);
  if (!a.motion_covariance.empty()) options.motion_covariances = ReadPoseCovariances(a.motion_covariance);
  return options;
}

int Evaluate(const Arguments& a) {
  if (!a.plot.empty()) DrawingFormatOf(a.plot);  // throws before all work
  const TrajectoryFile estimate = Read(a.estimate, a.estimate_format, a.times, BadRows::kRefuse);
  const TrajectoryFile truth = Read(a.truth, a.truth_format, a.times, BadRows::kPassOver);
  CheckTimes(a, estimate, truth);
  const Accuracy accuracy = EvaluateTrajectory(estimate.poses, truth.poses, ToOptions(a));
  fmt::print("{}", AccuracyTable(accuracy));
  if (!a.json.empty()) WriteFileAtomically(a.json, ToJson(accuracy).dump(2) + "\n");
  if (!a.plot.empty()) WriteDrawing(a.plot, AccuracyFigure(fs::path(a.estimate).filename(), accuracy));
  if (!accuracy.pairs.empty()) return 0;
  PrintError("evaluate: " + accuracy.note);
  return 1;
}

}  // namespace

int RunEvaluate(int argc, char** argv) {
  const std::string_view first = argc > 1 ? argv[1] : "";
  if (first == "places") return RunEvaluatePlaces(argc - 1, argv + 1);
  if (first == "compare") return RunEvaluateCompare(argc - 1, argv + 1);
  if (first == "figures") return RunEvaluateFigures(argc - 1, argv + 1);
  CLI::App app("Compares an estimated trajectory with the truth. docs/metrics.md defines the numbers.", "evaluate");
  Arguments arguments;
  AddOptions(app, arguments);
  app.footer(
      "`evaluate compare RUN...` compares several runs, `evaluate figures RUN` draws a run for "
      "print,\n"
      "and `evaluate places DATASET...` judges place recognition; each has its --help.");
  return RunCommandLine(app, argc, argv, [&] { return Evaluate(arguments); });
}

}  // namespace plslam::evaluate
