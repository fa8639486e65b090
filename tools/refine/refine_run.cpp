// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/refine_run.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/datasets/camera_file.h"
#include "core/files/atomic_file.h"
#include "core/io/maps/map_camera.h"
#include "core/io/maps/map_file.h"
#include "core/io/trajectories/trajectory.h"
#include "core/run/result_files.h"
#include "core/run/run.h"
#include "tools/evaluate/accuracy.h"
#include "tools/refine/followed_frames.h"
#include "viewer_headless/report/report_page.h"

namespace plslam::refine {
namespace {

namespace fs = std::filesystem;
using reference::kPairSize;

Displacements DisplacementsOf(const Map& before, const Map& after) {
  Displacements displacements;
  for (const auto& [id, keyframe] : before.keyframes()) {
    const MapKeyframe* refined = after.FindKeyframe(id);
    displacements[keyframe.t_ns] = refined->T_w_kf * keyframe.T_w_kf.Inverse();
  }
  return displacements;
}

Trajectory KeyframesOf(const Map& map) {
  std::map<int64_t, SE3> by_time;
  for (const auto& [id, keyframe] : map.keyframes()) by_time[keyframe.t_ns] = keyframe.T_w_kf;
  Trajectory keyframes;
  for (const auto& [t_ns, T_w_kf] : by_time) keyframes.push_back({t_ns, T_w_kf});
  return keyframes;
}

/// Only displacements of keyframes that are frames of the trajectory: those of its run.
Displacements OfTrajectory(const Displacements& all, const Trajectory& frames) {
  Displacements chosen;
  for (const TrajectoryPose& frame : frames) {
    const auto found = all.find(frame.t_ns);
    if (found != all.end()) chosen.insert(*found);
  }
  return chosen;
}

RigCalibration RigOf(const StereoCamera& camera, const PairParameters& pair) {
  RigCalibration rig;
  rig.name = "refined";
  rig.baseline_m = camera.baseline_m;
  rig.left.width_px = camera.width_px;
  rig.left.height_px = camera.height_px;
  rig.left.fx_px = rig.left.fy_px = camera.f_px;
  rig.left.cx_px = camera.cx_px;
  rig.left.cy_px = camera.cy_px;
  if (pair[reference::kRadial] != 0.0) rig.left.distortion = {pair[reference::kRadial], 0.0, 0.0, 0.0};
  rig.right = rig.left;
  rig.right.fx_px = rig.right.fy_px = camera.f_px * (1.0 + pair[reference::kFocalRatio]);
  const Eigen::Vector3d centre =
      camera.baseline_m * Eigen::Vector3d(1.0, pair[reference::kDirectionY], pair[reference::kDirectionZ]);
  const Eigen::Vector3d turn(pair[reference::kTurnX], pair[reference::kTurnY], pair[reference::kTurnZ]);
  rig.right.T_b_cam = SE3(ExpSO3(turn).conjugate(), centre);
  rig.baseline_m = centre.norm();
  return rig;
}

std::string ParameterText(const PairEstimate& pair, size_t i) {
  const PairParameterRow& row = PairParameterRows()[i];
  const double sigma = row.shown_per_unit * pair.sigma[i];
  switch (pair.state[i]) {
    case PairState::kEstimated:
      return fmt::format("{}: {:+.4f} {} (sigma {:.4f})\n", row.name, row.shown_per_unit * pair.value[i], row.unit,
                         sigma);
    case PairState::kUndetermined:
      return fmt::format("{}: not determined by these images, left as it was\n", row.name);
    case PairState::kAsGiven:
      return fmt::format("{}: as given, within three sigmas of {:.4f} {}\n", row.name, sigma, row.unit);
    case PairState::kUnconfirmed:
      return fmt::format("{}: as given, a change is not confirmed by keyframes without which it was estimated\n",
                         row.name);
    case PairState::kNotAsked:
      break;
  }
  return "";
}

std::string CameraText(const StereoCamera& camera, const RefineReport& report, CameraChoice choice) {
  std::string text = "# The rectified pair of the map, as a rig of its rectified images.\n";
  if (choice == CameraChoice::kFixed) text += "# It was not estimated: --camera intrinsics or all does that.\n";
  for (size_t i = 0; i < kPairSize; ++i) {
    const std::string parameter = ParameterText(report.pair, i);
    if (!parameter.empty()) text += "# " + parameter;
  }
  return text + CameraFileText(RigOf(camera, report.pair.value));
}

nlohmann::ordered_json ToJson(const MapFit& fit) {
  return {{"keyframes", fit.keyframes},
          {"points", fit.points},
          {"lines", fit.lines},
          {"point_observations", fit.point_observations},
          {"line_observations", fit.line_observations},
          {"rms_normalised", fit.normalised},
          {"rms_points_px", fit.point_px},
          {"rms_lines_px", fit.line_px},
          {"loops", fit.loops},
          {"rms_loops_m", fit.loop_m},
          {"length_m", fit.length_m}};
}

const char* StateName(PairState state) {
  switch (state) {
    case PairState::kEstimated:
      return "estimated";
    case PairState::kUndetermined:
      return "not determined";
    case PairState::kAsGiven:
      return "as given";
    case PairState::kUnconfirmed:
      return "not confirmed";
    case PairState::kNotAsked:
      break;
  }
  return "not asked";
}

nlohmann::ordered_json ToJson(const PairEstimate& pair) {
  nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
  for (size_t i = 0; i < kPairSize; ++i) {
    const PairParameterRow& row = PairParameterRows()[i];
    if (pair.state[i] == PairState::kNotAsked) continue;
    nlohmann::ordered_json parameter{{"name", row.name}, {"unit", row.unit}};
    parameter["state"] = StateName(pair.state[i]);
    parameter["value"] = row.shown_per_unit * pair.value[i];
    parameter["sigma"] = pair.state[i] == PairState::kUndetermined
                             ? nlohmann::ordered_json()
                             : nlohmann::ordered_json(row.shown_per_unit * pair.sigma[i]);
    parameters.push_back(parameter);
  }
  return parameters;
}

nlohmann::ordered_json SummaryOf(const RefineRequest& request, const RefinedRun& run, const StoredMap& stored) {
  const RefineReport& report = run.report;
  nlohmann::ordered_json summary;
  summary["refined_from"] = request.source;
  summary["sessions"] = nlohmann::ordered_json::array();
  for (const auto& [session, newest] : stored.sessions) summary["sessions"].push_back(std::to_string(session.value));
  summary["before"] = ToJson(report.before);
  summary["after"] = ToJson(report.after);
  if (run.errors) {
    summary["before"]["ate_m"] = run.errors->before_m;
    summary["after"]["ate_m"] = run.errors->after_m;
  }
  summary["passes"] = nlohmann::ordered_json::array();
  for (const RefineReport::Pass& pass : report.passes) {
    summary["passes"].push_back({{"cost_before", pass.cost_before},
                                 {"cost_after", pass.cost_after},
                                 {"iterations", pass.iterations},
                                 {"seconds", pass.seconds},
                                 {"changed_observations", pass.changed_observations}});
  }
  summary["camera"] = ToJson(report.pair);
  summary["parts"] = report.parts;
  summary["interrupted"] = report.stopped;
  return summary;
}

std::string TableOf(const RefinedRun& run) {
  const RefineReport& report = run.report;
  std::string text = fmt::format("{:<34} {:>12} {:>12}\n", "", "before", "after");
  const auto count = [&text](const char* name, int64_t before, int64_t after) {
    text += fmt::format("{:<34} {:>12} {:>12}\n", name, before, after);
  };
  const auto number = [&text](const char* name, double before, double after, int digits) {
    text += fmt::format("{:<34} {:>12.{}f} {:>12.{}f}\n", name, before, digits, after, digits);
  };
  const MapFit& before = report.before;
  const MapFit& after = report.after;
  count("points", before.points, after.points);
  count("lines", before.lines, after.lines);
  count("fitting observations of points", before.point_observations, after.point_observations);
  count("fitting observations of lines", before.line_observations, after.line_observations);
  number("residual, in sigmas (rms)", before.normalised, after.normalised, 4);
  number("residual of points, px (rms)", before.point_px, after.point_px, 4);
  number("residual of lines, px (rms)", before.line_px, after.line_px, 4);
  if (before.loops > 0) number("position at loops, m (rms)", before.loop_m, after.loop_m, 4);
  number("length along keyframes, m", before.length_m, after.length_m, 3);
  if (run.errors) number("error to the ground truth, m (ATE)", run.errors->before_m, run.errors->after_m, 5);
  for (size_t i = 0; i < kPairSize; ++i) text += ParameterText(report.pair, i);
  if (report.parts > 1) {
    text +=
        fmt::format("the map has {} parts that nothing connects: each was adjusted in its own frame\n", report.parts);
  }
  if (!report.has_covariances && !report.stopped) {
    text += "the information of the poses is singular: their covariances are those before\n";
  }
  if (report.stopped) text += "interrupted: the best map so far\n";
  return text;
}

double AteOf(const Trajectory& estimate, const Trajectory& truth) {
  evaluate::EvaluateOptions options;
  options.max_difference_ns = kSameMoment_ns;
  return evaluate::EvaluateTrajectory(estimate, truth, options).ate_m.rmse;
}

std::optional<RefineErrors> ErrorsOf(const Run& run, const Trajectory& before, const Trajectory& after) {
  if (before.empty() || !run.truth) return std::nullopt;
  const RefineErrors errors{AteOf(before, *run.truth), AteOf(after, *run.truth)};
  if (!(errors.before_m > 0.0) || !std::isfinite(errors.after_m)) return std::nullopt;
  return errors;
}

void CheckOut(const RefineRequest& request, const std::string& folder) {
  std::error_code ignored;
  const fs::path out = fs::weakly_canonical(request.out, ignored);
  const fs::path in =
      fs::weakly_canonical(folder.empty() ? fs::path(request.source).parent_path() : fs::path(folder), ignored);
  if (out == in || (folder.empty() && in.empty() && out == fs::current_path())) {
    throw std::runtime_error(fmt::format(
        "--out {}: is the folder of the map that is refined, which is kept: give another one", request.out));
  }
}

}  // namespace

RefinedRun RefineRun(const RefineRequest& request) {
  const Run source = ReadRun(request.source, run_content::kMap | run_content::kTrajectory | run_content::kTruth);
  const Trajectory before = source.trajectory.value_or(Trajectory());
  if (!source.map) {
    throw std::runtime_error(fmt::format("{}: has no map (.plmap), which refining needs: run with --save-map {}/{}",
                                         request.source, request.source, result_file::kMap));
  }
  CheckOut(request, source.folder);
  MakeFolder(request.out);
  StoredMap refined = *source.map;
  StereoCamera camera = MapCamera(refined, source.map_path);
  RefinedRun run;
  try {
    run.report = RefineMap(refined, camera, request.options);
  } catch (const std::exception& e) {
    throw std::runtime_error(fmt::format("{}: {}", source.map_path, e.what()));
  }
  const Displacements displacements = DisplacementsOf(source.map->map, refined.map);
  const Trajectory frames = FollowKeyframes(before, OfTrajectory(displacements, before));
  const Trajectory keyframes = KeyframesOf(refined.map);
  run.errors = ErrorsOf(source, before, frames);
  run.table = TableOf(run);

  const fs::path out(request.out);
  WriteMapFile((out / result_file::kMap).string(), refined);
  WriteTrajectory((out / result_file::kTrajectory.tum).string(), TrajectoryFormat::kTum,
                  frames.empty() ? keyframes : frames);
  WriteTrajectory((out / result_file::kKeyframes.tum).string(), TrajectoryFormat::kTum, keyframes);
  WriteFileAtomically((out / "camera.yaml").string(), CameraText(camera, run.report, request.options.camera));
  if (source.truth) {
    fs::copy_file(fs::path(source.folder) / result_file::kTruth, out / result_file::kTruth,
                  fs::copy_options::overwrite_existing);
  }
  const std::string summary = SummaryOf(request, run, refined).dump(2) + "\n";
  WriteFileAtomically((out / result_file::kSummary).string(), summary);
  const fs::path report = fs::path(source.folder) / result_file::kReport;
  if (!source.folder.empty() && fs::is_regular_file(report)) {
    std::ifstream stream(report, std::ios::binary);
    const std::optional<std::string> page = viewer::FillRefinement(viewer::ReadPage(stream), summary);
    if (page) WriteFileAtomically((out / result_file::kReport).string(), *page);
    if (!page)
      run.table += fmt::format("{}: is from an older version, without a place for this table\n", report.string());
  }
  return run;
}

}  // namespace plslam::refine
