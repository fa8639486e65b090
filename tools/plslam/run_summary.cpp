// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/process/process_signals.h"
#include "core/run/process_names.h"
#include "core/run/run_counters.h"
#include "tools/plslam/yaml_to_json.h"

namespace plslam::launcher {
namespace {

using nlohmann::json;

/// Fewer digits than a double has, for readability.
double Rounded(double value, double step) { return std::round(value / step) * step; }

json RoundedOrNull(const std::optional<double>& value, double step) {
  return value && std::isfinite(*value) ? json(Rounded(*value, step)) : json(nullptr);
}

/// Returns the number, or a dash for a missing measurement.
std::string NumberText(const json& value, int digits) {
  const bool known = value.is_number() && std::isfinite(value.get<double>());
  return known ? fmt::format("{:.{}f}", value.get<double>(), digits) : "-";
}

json QuantilesToJson(const QuantileSketch& samples) {
  return {{"median", Rounded(samples.Quantile(0.5), 1e-4)}, {"p95", Rounded(samples.Quantile(0.95), 1e-4)}};
}

json StagesToJson(const RunStatistics& statistics) {
  json stages = json::object();
  for (const auto& [name, samples] : statistics.stage_ms()) {
    stages[name] = QuantilesToJson(samples);
  }
  return stages;
}

bool HasMap(const RunSummary& summary) { return summary.map != nullptr && summary.map->version() > 0; }

json LandmarksToJson(const RunSummary& summary) {
  if (HasMap(summary)) {
    return {{"points", summary.map->totals().points}, {"lines", summary.map->totals().lines}};
  }
  return {{"points", summary.statistics->landmark_points()}, {"lines", summary.statistics->landmark_lines()}};
}

json MapToJson(const RunSummary& summary) {
  if (!HasMap(summary)) return nullptr;
  const MapStatistics& map = *summary.map;
  json result = {{"keyframes", map.totals().keyframes},
                 {"loops", map.totals().loops},
                 {"observations_per_point", Rounded(map.ObservationsPerPoint(), 1e-3)},
                 {"observations_per_line", Rounded(map.ObservationsPerLine(), 1e-3)},
                 {"reprojection_before_px", RoundedOrNull(map.ReprojectionBefore_px(), 1e-4)},
                 {"reprojection_after_px", RoundedOrNull(map.ReprojectionAfter_px(), 1e-4)}};
  for (const auto& [stage, samples] : map.stage_ms()) {
    result[stage == stage_name::kAdjust ? "adjustment_ms" : stage + "_ms"] = QuantilesToJson(samples);
  }
  return result;
}

json LoopsToJson(const RunSummary& summary) {
  if (summary.loops == nullptr || summary.loops->keyframes() + summary.loops->asked() == 0) return nullptr;
  const LoopStatistics& loops = *summary.loops;
  return {{"keyframes", loops.keyframes()},
          {"relocalisations", {{"asked", loops.asked()}, {"found", loops.found()}}},
          {"detect_ms", QuantilesToJson(loops.detect_ms())},
          {"correct_ms", QuantilesToJson(loops.correct_ms())},
          {"whole_map_ms", QuantilesToJson(loops.adjust_ms())}};
}

json WarningsToJson(const std::vector<RunWarning>& warnings) {
  json result = json::array();
  for (const RunWarning& warning : warnings) result.push_back(json(ToJson(warning)));
  return result;
}

json MovingToJson(const MovingTally& moving) {
  return {{"bodies", moving.bodies},
          {"frames", moving.frames},
          {"largest_percent", Rounded(100.0 * moving.largest_share, 0.1)},
          {"first_frame", moving.first_frame.value},
          {"last_frame", moving.last_frame.value}};
}

json DataToJson(const RunCounters& counters) {
  return {{"points_seen", counters.Sum(kPointsSeen)},
          {"points_matched", counters.Sum(kPointsMatched)},
          {"points_ambiguous", counters.Sum(kPointsAmbiguous)},
          {"dark_frames", counters.Sum(kFramesDark)},
          {"corner_rows_px", Rounded(counters.Largest(kCornerRows), 1e-3)},
          {"length_error_percent", Rounded(counters.Largest(kLengthError), 1e-2)},
          {"length_sigma_percent", Rounded(counters.Largest(kLengthSigma), 1e-2)}};
}

/// Null without an inertial sensor.
json ImuToJson(const RunCounters& counters) {
  const std::optional<ImuFigures> imu = ImuFiguresOf(counters);
  if (!imu) return nullptr;
  return {{"used_frames", imu->used_frames},
          {"innovation", Rounded(imu->innovation, 1e-3)},
          {"delay_ms", imu->delay ? json(Rounded(imu->delay->ms, 1e-3)) : json(nullptr)},
          {"delay_sigma_ms", imu->delay ? json(Rounded(imu->delay->sigma_ms, 1e-3)) : json(nullptr)},
          {"rate_bias_rad_s", imu->rate_bias_rad_s},
          {"rate_bias_sigma_rad_s", imu->rate_bias_sigma_rad_s},
          {"force_bias_m_s2", imu->force_bias_m_s2},
          {"force_bias_sigma_m_s2", imu->force_bias_sigma_m_s2}};
}

/// "1 loop", "2 loops".
std::string Counted(int64_t n, const char* name) { return fmt::format("{} {}{}", n, name, n == 1 ? "" : "s"); }

std::string Line(const char* name, const std::string& text) { return fmt::format("  {:<10} {}\n", name, text); }

/// "118 of 120 tracked (98.3 %), 2 initialising".
std::string FramesToText(const json& s) {
  const json& percent = s["tracked_percent"];
  std::string text =
      fmt::format("{} of {} tracked{}", s["tracked_frames"].get<int64_t>(), s["all_frames"].get<int64_t>(),
                  percent.is_number() ? fmt::format(" ({:.1f} %)", percent.get<double>()) : "");
  constexpr std::pair<const char*, const char*> kOthers[] = {{"initialising_frames", "initialising"},
                                                             {"lost_frames", "lost"},
                                                             {"skipped_frames", "skipped"},
                                                             {"bad_frames", "unreadable"},
                                                             {"unanswered_frames", "unanswered"}};
  for (const auto& [member, word] : kOthers) {
    const auto n = s[member].get<int64_t>();
    if (n > 0) text += fmt::format(", {} {}", n, word);
  }
  return text;
}

/// "2 objects, up to 38.0 % of the features, frames 40 to 75".
std::string MovingToText(const json& moving) {
  return fmt::format("{}, up to {:.1f} % of the features, frames {} to {}",
                     Counted(moving["bodies"].get<int64_t>(), "object"), moving["largest_percent"].get<double>(),
                     moving["first_frame"].get<int64_t>(), moving["last_frame"].get<int64_t>());
}

/// "used in 95 of 100 frames, normalised innovation 1.02".
std::string ImuToText(const json& s) {
  const json& imu = s["imu"];
  return fmt::format("used in {} of {} frames, normalised innovation {:.2f}", imu["used_frames"].get<int64_t>(),
                     s["frames"].get<int64_t>(), imu["innovation"].get<double>());
}

std::string SpeedToText(const json& s) {
  const auto wall_s = s["wall_s"].get<double>();
  const json& stages = s["stage_ms"];
  if (!stages.contains(stage_name::kTotal)) return fmt::format("{:.1f} s in total", wall_s);
  const json& age = s["pose_age_ms"];
  return fmt::format(
      "{:.1f} ms per frame (95 % below {:.1f}), poses {:.1f} ms after their frames (99 % below {:.1f}), {:.1f} s in "
      "total",
      stages[stage_name::kTotal]["median"].get<double>(), stages[stage_name::kTotal]["p95"].get<double>(),
      age["median"].get<double>(), age["p99"].get<double>(), wall_s);
}

std::string MapToText(const json& s, bool verbose) {
  const json& map = s["map"];
  const json& landmarks = s["landmarks"];
  const json& keyframes = map.is_object() ? map["keyframes"] : s["keyframes"];
  std::string text = Counted(keyframes.get<int64_t>(), "keyframe") + ", " +
                     Counted(landmarks["points"].get<int64_t>(), "point") + ", " +
                     Counted(landmarks["lines"].get<int64_t>(), "line");
  if (s["loop_closing"].is_object()) {
    const json& asked = s["loop_closing"]["relocalisations"];
    text += ", " + Counted(s["loops"].get<int64_t>(), "loop");
    if (asked["asked"] > 0) {
      text +=
          fmt::format(", relocalised {} of {} times", asked["found"].get<int64_t>(), asked["asked"].get<int64_t>());
    }
  }
  if (!verbose || !map.is_object()) return text;
  return text + fmt::format("; {:.1f} observations per point, {:.1f} per line, reprojection {} -> {} px",
                            map["observations_per_point"].get<double>(), map["observations_per_line"].get<double>(),
                            NumberText(map["reprojection_before_px"], 3),
                            NumberText(map["reprojection_after_px"], 3));
}

/// `lost` of the summary counts messages that were requested again; this text counts those that never arrived.
std::string MessagesToText(const json& messages) {
  const auto repaired = messages["repaired"].get<int64_t>();
  return fmt::format("{} lost, {} sent again, {} rejected",
                     std::max<int64_t>(0, messages["lost"].get<int64_t>() - repaired), repaired,
                     messages["rejected"].get<int64_t>());
}

/// Returns "vo 2, viewer 1"; empty without restarts.
std::string RestartsToText(const json& processes) {
  std::string text;
  for (const auto& [name, process] : processes.items()) {
    const auto n = process["restarts"].get<int>();
    if (n > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, n);
  }
  return text;
}

/// A row for each member that has quantiles.
std::string QuantilesToText(const json& members) {
  std::string text;
  for (const auto& [name, ms] : members.items()) {
    if (!ms.is_object() || !ms.contains("p95")) continue;
    const std::string stage = name.ends_with("_ms") ? name.substr(0, name.size() - 3) : name;
    text += fmt::format("  {:<24} {:>9.3f} {:>9.3f}\n", stage, ms["median"].get<double>(), ms["p95"].get<double>());
  }
  return text;
}

json ProcessesToJson(const RunSummary& summary, int64_t frames) {
  json processes = json::object();
  for (const ProcessReport& report : summary.processes) {
    processes[report.name] = {
        {"cpu_s", Rounded(report.cpu_s, 1e-3)},
        {"cpu_ms_per_frame", frames > 0 ? Rounded(1e3 * report.cpu_s / static_cast<double>(frames), 1e-3) : 0.0},
        {"peak_memory_mb", Rounded(report.peak_memory_mb, 0.1)},
        {"restarts", report.restarts},
        {"slowest_restart_s", Rounded(report.slowest_restart_s, 1e-3)},
        {"longest_queue", report.longest_queue},
        {"exit_code", report.exit_code ? json(*report.exit_code) : json(nullptr)}};
    if (report.exit_signal != 0) processes[report.name]["exit_signal"] = bus::SignalName(report.exit_signal);
  }
  return processes;
}

/// A run that the user ends is as good as one that ends by itself: a live camera has no other end.
std::string OutcomeToText(const json& s) {
  if (s["completed"]) return "completed";
  return s["reason"] == kInterrupted ? "ended by the user" : "NOT completed: " + s["reason"].get<std::string>();
}

/// Returns "ATE 0.012 m, live 0.015 m, ..." from the named results of `evaluate`.
std::string AccuracyToText(const json& s, bool verbose) {
  if (!s["accuracy"].is_object()) return "no ground truth";
  const json& accuracy = s["accuracy"];
  const json ate_m = accuracy.value("ate_m", json(nullptr));
  if (!ate_m.is_number()) {
    return fmt::format("ATE -: {}", accuracy.value("note", "no frame has both an estimated and a true pose"));
  }
  std::string text = fmt::format("ATE {} m", NumberText(ate_m, 4));
  if (s["accuracy_live_ate_m"].is_number())
    text += fmt::format(", live {} m", NumberText(s["accuracy_live_ate_m"], 4));
  const json kitti = accuracy.value("kitti", json::object());
  if (kitti.value("segments", 0) > 0)
    text += fmt::format(", KITTI t_rel {} %", NumberText(kitti["t_rel_percent"], 3));
  text += fmt::format(", true path {} m", NumberText(accuracy.value("true_path_m", json(nullptr)), 1));
  for (const json& relative : verbose ? accuracy.value("rpe", json::array()) : json::array()) {
    if (relative["translation_m"]["n"] == 0) continue;
    text += fmt::format(", RPE over {} {} m {} deg", relative["delta"].get<std::string>(),
                        NumberText(relative["translation_m"]["rmse"], 4),
                        NumberText(relative["rotation_deg"]["rmse"], 3));
  }
  return text;
}

std::string TablesToText(const json& s) {
  std::string text;
  const auto add = [&](const char* name, const json& members) {
    text += fmt::format("\n  {:<24} {:>9} {:>9}\n", name, "median", "95 %") + QuantilesToText(members);
  };
  add("stage, ms per frame", s["stage_ms"]);
  if (s["map"].is_object()) add("map, ms per keyframe", s["map"]);
  if (s["loop_closing"].is_object()) add("loops, ms per keyframe", s["loop_closing"]);
  text += fmt::format("\n  {:<24} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "process", "CPU ms/fr", "CPU s", "peak MB",
                      "restarts", "queue");
  for (const auto& [name, p] : s["processes"].items()) {
    text += fmt::format("  {:<24} {:>9.2f} {:>9.2f} {:>9.0f} {:>9} {:>9}\n", name,
                        p["cpu_ms_per_frame"].get<double>(), p["cpu_s"].get<double>(),
                        p["peak_memory_mb"].get<double>(), p["restarts"].get<int>(), p["longest_queue"].get<int>());
  }
  return text;
}

}  // namespace

RunFindings FindingsOf(const RunSummary& summary) {
  RunFindings findings;
  findings.dataset = summary.dataset;
  findings.map = summary.map_file;
  findings.frames = summary.frames;
  findings.Take(summary.counters);
  findings.recordings = summary.recordings;
  findings.published = summary.warnings;
  if (!summary.accuracy) return findings;
  const json& accuracy = *summary.accuracy;
  const auto number = [&](const char* path) {
    const json::json_pointer pointer(path);
    const bool known = accuracy.contains(pointer) && accuracy[pointer].is_number();
    return known ? std::optional(accuracy[pointer].get<double>()) : std::nullopt;
  };
  findings.ate_m = number("/ate_m");
  // Null, and yet there are poses to compare: too large for a number.
  const bool too_large = !findings.ate_m && number("/poses/associated").value_or(0.0) > 0.0;
  const double without = too_large ? std::numeric_limits<double>::infinity() : 0.0;
  if (too_large) findings.ate_m = without;
  findings.true_spread_m = number("/true_spread_m").value_or(without);
  findings.nees_pose = number("/nees_pose/mean").value_or(0.0);
  findings.nees_poses = static_cast<int64_t>(number("/nees_pose/n").value_or(0.0));
  return findings;
}

json SummaryToJson(const RunSummary& summary) {
  const RunStatistics& s = *summary.statistics;
  const FrameTally& frames = summary.frames;
  json configuration = json::object();
  for (const auto& [process, yaml] : summary.configurations) configuration[process] = YamlToJson(yaml);
  json sessions = json::array();
  for (const SessionId session : s.sessions()) sessions.push_back(std::to_string(session.value));
  return {{"dataset", summary.dataset},
          {"sessions", sessions},
          {"version", summary.version},
          {"completed", summary.completed},
          {"reason", summary.reason},
          {"wall_s", Rounded(summary.wall_s, 1e-3)},
          {"warnings", WarningsToJson(WarningsOf(FindingsOf(summary)))},
          {"frames", frames.answered()},
          {"tracked_frames", frames.tracked},
          {"initialising_frames", frames.initialising},
          {"lost_frames", frames.lost},
          {"skipped_frames", frames.skipped},
          {"bad_frames", frames.unreadable},
          {"carried_frames", static_cast<int64_t>(summary.counters.Sum(kFramesCarried))},
          {"unanchored_frames", static_cast<int64_t>(summary.counters.Sum(kFramesUnanchored))},
          {"unanswered_frames", frames.unanswered},
          {"missing_pictures", static_cast<int64_t>(summary.counters.Largest(kPicturesMissing))},
          {"all_frames", frames.all()},
          {"tracked_percent", frames.tracked_percent() ? json(*frames.tracked_percent()) : json(nullptr)},
          {"data", DataToJson(summary.counters)},
          {"imu", ImuToJson(summary.counters)},
          {"moving_objects", MovingToJson(s.moving())},
          {"keyframes", s.keyframes()},
          {"landmarks", LandmarksToJson(summary)},
          {"map", MapToJson(summary)},
          {"loops", summary.loops != nullptr ? summary.loops->loops() : 0},
          {"loop_closing", LoopsToJson(summary)},
          {"accuracy", summary.accuracy ? *summary.accuracy : json(nullptr)},
          {"accuracy_live_ate_m", RoundedOrNull(summary.live_ate_m, 1e-6)},
          {"path_m", RoundedOrNull(summary.path_m, 1e-3)},
          {"recordings", summary.recordings},
          {"stage_ms", StagesToJson(s)},
          {"pose_age_ms",
           {{"median", Rounded(s.age_ms().Quantile(0.5), 1e-4)}, {"p99", Rounded(s.age_ms().Quantile(0.99), 1e-4)}}},
          {"messages",
           {{"lost", summary.messages.lost},
            {"repaired", summary.messages.repaired},
            {"rejected", summary.messages.rejected}}},
          {"processes", ProcessesToJson(summary, frames.answered())},
          {"configuration", configuration}};
}

std::string SummaryToText(const json& s, bool verbose) {
  const auto n_warnings = static_cast<int64_t>(s["warnings"].size());
  std::string text = fmt::format("{} {}{}\n", s["dataset"].get<std::string>(), OutcomeToText(s),
                                 n_warnings == 0 ? "" : fmt::format(" ({})", Counted(n_warnings, "warning")));
  text += Line("frames", FramesToText(s));
  text += Line("accuracy", AccuracyToText(s, verbose));
  if (s["path_m"].is_number()) text += Line("path", NumberText(s["path_m"], 2) + " m");
  if (s["imu"].is_object()) text += Line("imu", ImuToText(s));
  const json& moving = s["moving_objects"];
  if (moving["frames"] > 0) text += Line("moving", MovingToText(moving));
  text += Line("speed", SpeedToText(s));
  text += Line("map", MapToText(s, verbose));
  if (const std::string restarts = RestartsToText(s["processes"]); !restarts.empty())
    text += Line("restarts", restarts);
  const json& messages = s["messages"];
  if (verbose || messages["lost"] > 0 || messages["rejected"] > 0) text += Line("messages", MessagesToText(messages));
  return verbose ? text + TablesToText(s) : text;
}

}  // namespace plslam::launcher
