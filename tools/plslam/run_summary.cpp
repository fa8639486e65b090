#include "tools/plslam/run_summary.h"

#include <fmt/format.h>

#include <cmath>

#include "core/process/process_signals.h"
#include "tools/plslam/yaml_to_json.h"

namespace plslam {
namespace {

using nlohmann::json;

/// Fewer digits than a double has: for people who open the file.
double Rounded(double value, double step) { return std::round(value / step) * step; }

json RoundedOrNull(const std::optional<double>& value, double step) {
  return value ? json(Rounded(*value, step)) : json(nullptr);
}

/// A dash where nothing was measured.
std::string NumberText(const json& value, int digits) {
  return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : "-";
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
    result[stage == "adjust" ? "adjustment_ms" : stage + "_ms"] = QuantilesToJson(samples);
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

std::string LoopsToText(const json& s) {
  const json& asked = s["loop_closing"]["relocalisations"];
  return fmt::format("  loops      {}, relocalised {} of {} times asked\n", s["loops"].get<int64_t>(),
                     asked["found"].get<int64_t>(), asked["asked"].get<int64_t>());
}

std::string MapToText(const json& map) {
  return fmt::format(
      "  map        {} keyframes, {:.1f} observations a point, {:.1f} a line, reprojection {} -> {} px\n",
      map["keyframes"].get<int64_t>(), map["observations_per_point"].get<double>(),
      map["observations_per_line"].get<double>(), NumberText(map["reprojection_before_px"], 3),
      NumberText(map["reprojection_after_px"], 3));
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

/// "ATE 0.012 m, ...", of what `evaluate` gives by name.
std::string AccuracyToText(const json& accuracy) {
  const json ate_m = accuracy.value("ate_m", json(nullptr));
  if (!ate_m.is_number())
    return fmt::format("ATE -, {}", accuracy.value("note", "no frame has a pose and a true one"));
  std::string text = fmt::format("ATE {} m", NumberText(ate_m, 4));
  for (const json& relative : accuracy.value("rpe", json::array())) {
    if (relative["translation_m"]["n"] == 0) continue;
    text +=
        fmt::format(", RPE over {} {:.4f} m {:.3f} deg", relative["delta"].get<std::string>(),
                    relative["translation_m"]["rmse"].get<double>(), relative["rotation_deg"]["rmse"].get<double>());
  }
  const json kitti = accuracy.value("kitti", json::object());
  if (kitti.value("segments", 0) > 0)
    text += fmt::format(", KITTI t_rel {:.3f} %", kitti["t_rel_percent"].get<double>());
  return text + fmt::format(", path {:.1f} m", accuracy.value("true_path_m", 0.0));
}

}  // namespace

int64_t AllFrames(const RunSummary& summary) {
  const RunStatistics& s = *summary.statistics;
  return s.frames() + s.skipped_frames() + summary.bad_frames + summary.unanswered_frames;
}

json SummaryToJson(const RunSummary& summary) {
  const RunStatistics& s = *summary.statistics;
  json configuration = json::object();
  for (const auto& [process, yaml] : summary.configurations) configuration[process] = YamlToJson(yaml);
  return {{"dataset", summary.dataset},
          {"version", summary.version},
          {"completed", summary.completed},
          {"reason", summary.reason},
          {"wall_s", Rounded(summary.wall_s, 1e-3)},
          {"frames", s.frames()},
          {"tracked_frames", s.tracked_frames()},
          {"skipped_frames", s.skipped_frames()},
          {"bad_frames", summary.bad_frames},
          {"unanswered_frames", summary.unanswered_frames},
          {"missing_pictures", summary.missing_pictures},
          {"all_frames", AllFrames(summary)},
          {"keyframes", s.keyframes()},
          {"landmarks", LandmarksToJson(summary)},
          {"map", MapToJson(summary)},
          {"loops", summary.loops != nullptr ? summary.loops->loops() : 0},
          {"loop_closing", LoopsToJson(summary)},
          {"accuracy", summary.accuracy ? *summary.accuracy : json(nullptr)},
          {"accuracy_live_ate_m", RoundedOrNull(summary.live_ate_m, 1e-6)},
          {"recordings", summary.recordings},
          {"stage_ms", StagesToJson(s)},
          {"messages",
           {{"lost", summary.messages.lost},
            {"repaired", summary.messages.repaired},
            {"rejected", summary.messages.rejected}}},
          {"processes", ProcessesToJson(summary, s.frames())},
          {"configuration", configuration}};
}

std::string SummaryToText(const json& s) {
  const auto frames = s["frames"].get<int64_t>(), tracked = s["tracked_frames"].get<int64_t>();
  const auto all = s["all_frames"].get<int64_t>();
  const double share = all > 0 ? 100.0 * static_cast<double>(tracked) / static_cast<double>(all) : 0.0;
  std::string text = fmt::format("{} {}\n", s["dataset"].get<std::string>(),
                                 s["completed"] ? "completed" : "NOT completed: " + s["reason"].get<std::string>());
  text += fmt::format("  frames     {} in {:.1f} s, {} tracked ({:.1f} %)", frames, s["wall_s"].get<double>(),
                      tracked, share);
  if (s["skipped_frames"] > 0) text += fmt::format(", {} skipped", s["skipped_frames"].get<int64_t>());
  if (s["bad_frames"] > 0) text += fmt::format(", {} unreadable", s["bad_frames"].get<int64_t>());
  if (s["unanswered_frames"] > 0) text += fmt::format(", {} unanswered", s["unanswered_frames"].get<int64_t>());
  text += fmt::format("\n  keyframes  {}, landmarks {} points and {} lines\n", s["keyframes"].get<int64_t>(),
                      s["landmarks"]["points"].get<int64_t>(), s["landmarks"]["lines"].get<int64_t>());
  if (s["map"].is_object()) text += MapToText(s["map"]);
  if (s["loop_closing"].is_object()) text += LoopsToText(s);
  text += fmt::format("  accuracy   {}",
                      s["accuracy"].is_object() ? AccuracyToText(s["accuracy"]) : std::string("no ground truth"));
  if (s["accuracy_live_ate_m"].is_number()) {
    text += fmt::format(", live ATE {:.4f} m", s["accuracy_live_ate_m"].get<double>());
  }
  text += "\n";
  text += fmt::format("  messages   {} lost, {} repaired, {} rejected\n", s["messages"]["lost"].get<int64_t>(),
                      s["messages"]["repaired"].get<int64_t>(), s["messages"]["rejected"].get<int64_t>());
  text += fmt::format("\n  {:<24} {:>9} {:>9}\n", "stage, ms a frame", "median", "95 %");
  text += QuantilesToText(s["stage_ms"]);
  if (s["map"].is_object()) {
    text += fmt::format("\n  {:<24} {:>9} {:>9}\n", "map, ms a keyframe", "median", "95 %");
    text += QuantilesToText(s["map"]);
  }
  if (s["loop_closing"].is_object()) {
    text += fmt::format("\n  {:<24} {:>9} {:>9}\n", "loops, ms a keyframe", "median", "95 %");
    text += QuantilesToText(s["loop_closing"]);
  }
  text += fmt::format("\n  {:<24} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "process", "CPU ms/fr", "CPU s", "peak MB",
                      "restarts", "queue");
  for (const auto& [name, p] : s["processes"].items()) {
    text += fmt::format("  {:<24} {:>9.2f} {:>9.2f} {:>9.0f} {:>9} {:>9}\n", name,
                        p["cpu_ms_per_frame"].get<double>(), p["cpu_s"].get<double>(),
                        p["peak_memory_mb"].get<double>(), p["restarts"].get<int>(), p["longest_queue"].get<int>());
  }
  return text;
}

}  // namespace plslam
