// SPDX-License-Identifier: BSD-3-Clause
// Accuracy and time of odometry in one process, without messages: a row for each dataset. For experiments; the official
// numbers come from `plslam run`.
//
//   accuracy_benchmark DATASET... [--set vo.tracking.reference=previous_frame] [--stride N] [--frames N]
//   accuracy_benchmark DATASET... --pieces N
//   accuracy_benchmark DATASET... --mapping | --loops [--forth-and-back] [--noise S] [--darkest F] [--blur S]
// [--covered F] [--dirt N [--dirt-seed S]]
//   accuracy_benchmark DATASET... --mapping --exact
//   accuracy_benchmark DATASET... --black FIRST COUNT [EVERY]
//   accuracy_benchmark DATASET... --imu-fault NAME [--imu-fault-size X]

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "core/config/config.h"
#include "core/datasets/open_dataset.h"
#include "loop_process/loop_service.h"
#include "tests/support/faulty_sensor.h"
#include "tests/support/loop_run.h"
#include "tests/support/odometry_run.h"
#include "tests/support/slam_run.h"
#include "tests/support/worse_images.h"
#include "tools/command_line/run_command_line.h"
#include "tools/train_vocabulary/vocabulary_trainer.h"

namespace {

using plslam::test::OdometryFrame;

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string StageMedians(const std::vector<OdometryFrame>& frames) {
  std::map<std::string, std::vector<double>> times;
  for (const OdometryFrame& frame : frames) {
    for (const plslam::vo::StageTime& stage : frame.stages) times[stage.name].push_back(stage.ms);
  }
  std::string text;
  for (auto& [name, values] : times) {
    char buffer[64];
    std::snprintf(buffer, sizeof buffer, " %s %.2f", name.c_str(), Median(values));
    text += buffer;
  }
  return text;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

template <class Member>
double Mean(const std::vector<OdometryFrame>& frames, Member member) {
  double sum = 0.0;
  for (const OdometryFrame& frame : frames) sum += frame.*member;
  return frames.empty() ? 0.0 : sum / static_cast<double>(frames.size());
}

void PrintFrame(int index, const OdometryFrame& f) {
  std::printf(
      "  %4d state %d points %d/%d lines %d/%d kf %d late %.1f ms readout %.1f ms  t %.4f %.4f %.4f  d %.2f %.2f "
      "%.2f\n",
      index, static_cast<int>(f.state), f.n_tracked_points, f.n_points, f.n_tracked_lines, f.n_lines,
      f.keyframe ? 1 : 0, 1e3 * f.late_s, 1e3 * f.readout_s, f.T_odom_l.translation().x(),
      f.T_odom_l.translation().y(), f.T_odom_l.translation().z(), f.disparity_offset_px(0), f.disparity_offset_px(1),
      f.disparity_offset_px(2));
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<size_t>(q * static_cast<double>(values.size())))];
}

double MeanFigure(const std::vector<plslam::AdjustmentFigures>& figures, double plslam::AdjustmentFigures::*member) {
  double sum = 0.0;
  for (const auto& f : figures) sum += f.*member;
  return figures.empty() ? 0.0 : sum / static_cast<double>(figures.size());
}

void PrintSlam(const std::string& name, const plslam::test::SlamRun& run) {
  std::printf(
      "%-40s SLAM lost %d keyframes %d ate final %.5f live %.5f | points %zu (%.1f) lines %zu (%.1f) | insert %.1f "
      "adjust "
      "%.1f 95%% %.1f | px %.3f -> %.3f\n",
      name.c_str(), plslam::test::LostFrames(run.live), run.keyframes,
      plslam::test::AbsoluteTrajectoryError(run.final), plslam::test::AbsoluteTrajectoryError(run.live), run.points,
      run.observations_per_point, run.lines, run.observations_per_line, Quantile(run.insert_ms, 0.5),
      Quantile(run.adjust_ms, 0.5), Quantile(run.adjust_ms, 0.95),
      MeanFigure(run.figures, &plslam::AdjustmentFigures::reprojection_before_px),
      MeanFigure(run.figures, &plslam::AdjustmentFigures::reprojection_after_px));
}

// Prints the frame, whether it is a keyframe, then live, final and true position.
void PrintPlaces(size_t i, const plslam::test::SlamRun& run) {
  const Eigen::Vector3d live = run.live[i].T_odom_l.translation();
  const Eigen::Vector3d final = run.final[i].T_odom_l.translation();
  const Eigen::Vector3d truth = run.live[i].T_w_l ? run.live[i].T_w_l->translation() : Eigen::Vector3d::Zero();
  std::printf("  %4zu %d  %.6f %.6f %.6f  %.6f %.6f %.6f  %.6f %.6f %.6f\n", i, run.live[i].keyframe ? 1 : 0,
              live.x(), live.y(), live.z(), final.x(), final.y(), final.z(), truth.x(), truth.y(), truth.z());
}

void PrintBits(const plslam::SE3& pose) {
  const Eigen::Vector4d q = pose.rotation().coeffs();
  const Eigen::Vector3d t = pose.translation();
  std::printf("  %a %a %a %a %a %a %a", q[0], q[1], q[2], q[3], t[0], t[1], t[2]);
}

// Prints all bits of the live pose, of the final one and of the live covariance, to compare two builds.
void PrintExactly(size_t i, const plslam::test::SlamRun& run) {
  std::printf("%zu", i);
  PrintBits(run.live[i].T_odom_l);
  PrintBits(run.final[i].T_odom_l);
  std::printf("  %a\n", run.live[i].motion_covariance.norm());
}

// Empty vocabularies will do where no loops are looked for.
plslam::PlaceRecogniser Places(bool with_loops, const plslam::PlaceOptions& options) {
  if (!with_loops) {
    return {plslam::train_vocabulary::TrainVocabulary({}, plslam::FeatureType::kPoints, {}),
            plslam::train_vocabulary::TrainVocabulary({}, plslam::FeatureType::kLines, {}), options};
  }
  return plslam::loop::LoadPlaces({}, options);
}

void PrintLoop(const char* what, const plslam::test::LoopOfRun& loop) {
  const plslam::loop::LoopEvidence& e = loop.evidence;
  std::printf(
      "    %s frame %3ld sees %3ld score %.3f: %s, inliers %d of %d cells %d share %.2f reverse %d confirming %d "
      "drift %.1f "
      "| moved %.2f m %.1f deg | off by %.3f m %.2f deg%s\n",
      what, static_cast<long>(loop.frame), static_cast<long>(loop.old_frame), loop.score,
      plslam::loop::LoopVerdictName(e.verdict), e.place.inliers, e.place.matches, e.place.cells,
      e.place.landmarks.Share(), e.reverse_inliers, e.confirming, e.drift_chi2, e.edge.T_old_kf.translation().norm(),
      e.edge.T_old_kf.Log().tail<3>().norm() * 57.3, loop.error_m, loop.error_deg, loop.IsFalse() ? " FALSE" : "");
}

void PrintLoops(const std::string& name, const plslam::test::LoopRun& run, bool verbose) {
  const auto wrong = std::count_if(run.loops.begin(), run.loops.end(), [](const auto& l) { return l.IsFalse(); });
  const auto truly = std::count_if(run.looked_at.begin(), run.looked_at.end(),
                                   [](const auto& l) { return l.error_m >= 0.0 && !l.IsFalse(); });
  PrintSlam(name, run.slam);
  std::printf(
      "    loops %zu false %td of %zu looked at, %td right | revisits %d closed %d, keyframes %d of %d | judge %.2f "
      "95%% "
      "%.2f | loop %.1f correct %.1f adjust %.1f max %.1f\n",
      run.loops.size(), wrong, run.looked_at.size(), truly, run.revisits.total, run.revisits.closed,
      run.revisits.closed_keyframes, run.revisits.keyframes, Mean(run.check_ms), Quantile(run.check_ms, 0.95),
      Median(run.loop_ms), Median(run.correct_ms), Median(run.adjust_ms), Quantile(run.adjust_ms, 1.0));
  for (size_t i = 0; i < run.loops.size(); ++i) {
    PrintLoop("LOOP", run.loops[i]);
    std::printf("      ate %.4f -> %.4f", run.ate_before_m[i], run.ate_corrected_m[i]);
    if (i < run.ate_adjusted_m.size()) std::printf(" -> %.4f", run.ate_adjusted_m[i]);
    std::printf("\n");
  }
  if (run.asked > 0) {
    std::printf("    asked %d found %d elsewhere %d, ms %.2f 95%% %.2f\n", run.asked, run.found, run.found_elsewhere,
                Mean(run.ask_ms), Quantile(run.ask_ms, 0.95));
  }
  for (const std::string& reason : run.refused) std::printf("    refused: %s\n", reason.c_str());
  for (const auto& loop : run.looked_at) {
    if (verbose) PrintLoop("    ", loop);
  }
}

struct Arguments {
  std::vector<std::string> datasets;
  std::vector<std::string> overrides;
  std::string config;
  bool verbose = false;
  bool exact = false;
  bool mapping = false;
  bool loops = false;
  int pieces = 0;
  int first = 0;
  plslam::test::Worsening worsening;
  std::vector<int> black;
  std::vector<double> up;
  std::string imu_fault;
  double imu_fault_size = 0.0;
};

void AddArguments(CLI::App& app, Arguments& a, plslam::test::LoopRunOptions& run) {
  app.add_option("datasets", a.datasets, "datasets")->required();
  app.add_option("--set", a.overrides, "KEY=VALUE");
  app.add_option("--config", a.config, "configuration file");
  app.add_option("--stride", run.stride, "every so many frames");
  app.add_option("--frames", run.max_frames, "at most so many");
  app.add_option("--first", a.first, "odometry alone: from this frame on");
  app.add_flag("--verbose", a.verbose, "a line for each frame");
  app.add_flag("--mapping", a.mapping, "tracking against the map instead of odometry alone");
  app.add_flag("--exact", a.exact, "with --mapping: all bits of the poses instead of figures and times");
  app.add_flag("--loops", a.loops, "mapping and loop closing");
  app.add_flag("--forth-and-back", run.forth_and_back, "with --loops: then all frames in reverse order");
  app.add_option("--pieces", a.pieces, "then pieces of so many frames on their own: their scales against the whole");
  app.add_option("--ask-every", run.ask_every, "with --loops: ask where every so many frames are");
  app.add_option("--noise", a.worsening.noise_sigma, "added to the images, grey values");
  app.add_option("--darkest", a.worsening.darkest, "factor of the grey values, that comes and goes");
  app.add_option("--blur", a.worsening.blur_sigma_px, "of the images, pixels");
  app.add_option("--dirt", a.worsening.dirt, "number of spots of dirt on each lens");
  app.add_option("--dirt-seed", a.worsening.dirt_seed, "for their sizes and places");
  app.add_option("--black", a.black, "black frames: the first, how many, and again after how many")->expected(2, 3);
  app.add_option("--up", a.up, "up in the frame of the truth: errors of the vertical by the inertial sensor")
      ->expected(3);
  app.add_option("--imu-fault", a.imu_fault, "a fault of the inertial sensor, as in synthetic worlds");
  app.add_option("--imu-fault-size", a.imu_fault_size, "its size");
  app.add_option("--covered", a.worsening.covered, "side of a black square, as a share of the image's height");
}

void ReadOptions(const Arguments& a, plslam::test::LoopRunOptions& run) {
  plslam::Config config;
  if (!a.config.empty()) config = plslam::Config::FromFile(a.config);
  for (const std::string& assignment : a.overrides) config.Override(assignment);
  config.Read("vo", run.vo);
  config.Read("mapping", run.mapping);
  config.Read("loop", run.loops);
}

std::string LastOf(const std::string& location, size_t length) {
  return location.substr(location.size() > length ? location.size() - length : 0);
}

void RunMapping(const std::string& location, const plslam::Dataset& dataset, const Arguments& a,
                const plslam::test::LoopRunOptions& options) {
  const auto run = plslam::test::RunSlam(dataset, options.vo, options.mapping, options.stride, options.max_frames);
  for (size_t i = 0; a.exact && i < run.live.size(); ++i) PrintExactly(i, run);
  if (a.exact) return;
  PrintSlam(LastOf(location, 40), run);
  for (size_t i = 0; a.verbose && i < run.live.size(); ++i) PrintPlaces(i, run);
}

/// The frames at which the inertial sensor is used, and the first sentences about it.
void PrintSensor(const std::vector<OdometryFrame>& frames) {
  const auto n_used = std::count_if(frames.begin(), frames.end(), [](const auto& f) { return f.uses_imu; });
  std::printf("    inertial sensor used in %td frames", n_used);
  for (size_t i = 1; i < frames.size(); ++i) {
    if (frames[i].uses_imu != frames[i - 1].uses_imu) std::printf(" %c%zu", frames[i].uses_imu ? '+' : '-', i);
  }
  std::printf("\n");
  for (std::string OdometryFrame::*sentence :
       {&OdometryFrame::imu_contradiction, &OdometryFrame::imu_sample_faults}) {
    const auto first =
        std::find_if(frames.begin(), frames.end(), [&](const auto& f) { return !(f.*sentence).empty(); });
    if (first != frames.end())
      std::printf("    frame %td: %s\n", first - frames.begin(), ((*first).*sentence).c_str());
  }
}

/// Errors from the last frame before black ones to the last of them, and to the frame after.
void PrintDarkness(const std::vector<OdometryFrame>& frames, size_t first, size_t count) {
  const auto print = [&](const char* name, size_t last) {
    const auto error = plslam::test::ErrorOfMotion(frames, first - 1, last);
    std::printf("  %s %.4f m (sigma %.4f) %.3f deg chi2 %.1f", name, error.translation_m, error.sigma_m,
                error.rotation_rad / plslam::kRadPerDeg, error.chi2);
  };
  std::printf("    frame %zu:", first);
  print("half", first + count / 2);
  print("last", first + count - 1);
  print("after", first + count);
  std::printf(" states %d %d\n", static_cast<int>(frames[first + count - 1].state),
              static_cast<int>(frames[first + count].state));
}

/// Errors of the vertical in degrees and in sigmas, of the frames after 2, 5, 10, ... seconds.
void PrintVerticals(const std::vector<OdometryFrame>& frames, const Eigen::Vector3d& up) {
  double most_sigmas = 0.0, next_s = 2.0;
  for (const OdometryFrame& frame : frames) {
    if (!frame.up || !frame.T_w_l) continue;
    const Eigen::Vector3d truth = (*frame.T_w_l * frame.T_l_c).rotation().conjugate() * up;
    const double angle_rad = std::atan2(truth.cross(frame.up->direction).norm(), truth.dot(frame.up->direction));
    most_sigmas = std::max(most_sigmas, angle_rad / frame.up->sigma_rad);
    const double t_s = 1e-9 * static_cast<double>(frame.t_ns - frames.front().t_ns);
    if (t_s < next_s && &frame != &frames.back()) continue;
    next_s = t_s < 5.0 ? 5.0 : 2.0 * next_s;
    std::printf("    vertical after %.1f s: %.3f deg, sigma %.3f deg\n", t_s, angle_rad / plslam::kRadPerDeg,
                frame.up->sigma_rad / plslam::kRadPerDeg);
  }
  std::printf("    vertical at worst: %.2f sigmas\n", most_sigmas);
}

void RunOdometry(const std::string& location, const plslam::Dataset& dataset, const Arguments& a,
                 const plslam::test::LoopRunOptions& options) {
  const auto frames =
      plslam::test::RunOdometry(dataset, options.vo, options.stride, options.max_frames, nullptr, a.first);
  const auto keyframes = std::count_if(frames.begin(), frames.end(), [](const auto& f) { return f.keyframe; });
  for (int i = 0; a.verbose && i < static_cast<int>(frames.size()); ++i) PrintFrame(i, frames[i]);
  std::printf("%-40s frames %zu lost %d keyframes %td ate %.5f nees %.2f points %.0f/%.0f lines %.0f/%.0f ms%s\n",
              LastOf(location, 40).c_str(), frames.size(), plslam::test::LostFrames(frames), keyframes,
              plslam::test::AbsoluteTrajectoryError(frames), plslam::test::MotionNees(frames),
              Mean(frames, &OdometryFrame::n_tracked_points), Mean(frames, &OdometryFrame::n_points),
              Mean(frames, &OdometryFrame::n_tracked_lines), Mean(frames, &OdometryFrame::n_lines),
              StageMedians(frames).c_str());
  if (!a.up.empty()) PrintVerticals(frames, Eigen::Vector3d(a.up[0], a.up[1], a.up[2]).normalized());
  if (dataset.rig().imu && options.vo.imu.enabled) PrintSensor(frames);
  const plslam::test::Worsening& w = a.worsening;
  for (int first = w.black_first; w.black_count > 0; first += w.black_every) {
    if (first < 1 || first + w.black_count >= static_cast<int>(frames.size())) break;
    PrintDarkness(frames, static_cast<size_t>(first), static_cast<size_t>(w.black_count));
    if (w.black_every > static_cast<int>(frames.size())) break;
  }
  for (int first = 0; a.pieces > 0 && first + a.pieces / 2 <= static_cast<int>(frames.size()); first += a.pieces) {
    const auto piece = plslam::test::RunOdometry(dataset, options.vo, 1, a.pieces, nullptr, first);
    std::printf("    frames %4d to %4d: scale against the whole %.4f\n", first,
                first + static_cast<int>(piece.size()) - 1, plslam::test::ScaleAgainst(piece, frames));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Accuracy and time of odometry in one process, without messages", "accuracy_benchmark");
  Arguments a;
  plslam::test::LoopRunOptions options;
  AddArguments(app, a, options);
  return plslam::RunCommandLine(app, argc, argv, [&] {
    cv::setNumThreads(1);
    ReadOptions(a, options);
    const plslam::PlaceRecogniser places = Places(a.loops, options.loops.places);
    for (const std::string& location : a.datasets) {
      const auto opened = plslam::OpenDataset(location, "");
      if (a.black.size() > 1) a.worsening.black_first = a.black[0];
      if (a.black.size() > 1) a.worsening.black_count = a.black[1];
      if (a.black.size() > 2) a.worsening.black_every = a.black[2];
      const plslam::test::WorseImages worse(*opened, a.worsening);
      std::optional<plslam::test::FaultySensor> faulty;
      if (!a.imu_fault.empty()) faulty.emplace(worse, a.imu_fault, a.imu_fault_size);
      const plslam::Dataset& dataset = faulty ? static_cast<const plslam::Dataset&>(*faulty) : worse;
      if (a.loops) {
        const plslam::test::LoopRun run = plslam::test::RunLoops(dataset, places, options);
        PrintLoops(LastOf(location, 60), run, a.verbose);
        for (size_t i = 0; a.verbose && i < run.slam.live.size(); ++i) PrintPlaces(i, run.slam);
      } else if (a.mapping) {
        RunMapping(location, dataset, a, options);
      } else {
        RunOdometry(location, dataset, a, options);
      }
    }
    return 0;
  });
}
