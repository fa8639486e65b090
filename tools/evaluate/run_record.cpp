// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/run_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <stdexcept>

#include "core/config/config.h"
#include "core/run/frame_tally.h"
#include "core/run/process_names.h"
#include "core/run/run.h"

namespace plslam::evaluate {
namespace {

using nlohmann::json;
using Value = std::optional<double>;

/// Returns the number at a path of names ("accuracy/ate_m"); nullopt if there is none.
Value At(const json& summary, const std::string& path) {
  const json::json_pointer pointer("/" + path);
  if (!summary.contains(pointer) || !summary[pointer].is_number()) return std::nullopt;
  return summary[pointer].get<double>();
}

/// Returns the relative translation error over the benchmark's lengths, or over short ones if the path is shorter than
/// those.
Value TRel(const json& s) {
  for (const char* part : {"accuracy/kitti/", "accuracy/kitti_short/"}) {
    if (At(s, std::string(part) + "segments").value_or(0.0) > 0.0) return At(s, std::string(part) + "t_rel_percent");
  }
  return std::nullopt;
}

/// There is a truth, and not one pose to compare with it.
bool IsUntracked(const json& s) { return At(s, "accuracy/poses/associated").value_or(1.0) <= 0.0; }

// Summaries of older versions have zero if nothing was tracked.
Value Ate(const json& s) { return IsUntracked(s) ? std::nullopt : At(s, "accuracy/ate_m"); }
Value LiveAte(const json& s) { return IsUntracked(s) ? std::nullopt : At(s, "accuracy_live_ate_m"); }

Value KeyframeRmse(const json& s) {
  if (At(s, "accuracy/keyframes/moving").value_or(0.0) <= 0.0) return std::nullopt;
  return At(s, "accuracy/keyframes/relative_rmse");
}

Value TrackedShare(const json& s) {
  const Value frames = At(s, "frames"), tracked = At(s, "tracked_frames");
  if (!frames || !tracked) return std::nullopt;
  // `frames` are those with a pose message. Older runs do not have the total number.
  const double all =
      At(s, "all_frames")
          .value_or(*frames + At(s, "skipped_frames").value_or(0.0) + At(s, "bad_frames").value_or(0.0));
  return TrackedPercent(*tracked, all);
}

Value SumOverProcesses(const json& s, const char* name) {
  Value sum;
  const json processes = s.value("processes", json::object());
  for (const auto& [process, report] : processes.items()) {
    if (report.contains(name) && report[name].is_number()) sum = sum.value_or(0.0) + report[name].get<double>();
  }
  return sum;
}

struct MetricRow {
  Metric metric;
  Value (*read)(const json& summary);
};

const std::vector<MetricRow>& Rows() {
  static const std::vector<MetricRow> kRows{
      {{"ate_m", "ATE", "m", 4, false}, Ate},
      {{"live_ate_m", "live ATE", "m", 4, false}, LiveAte},
      {{"t_rel_percent", "t_rel", "%", 3, false}, TRel},
      {{"keyframe_relative_rmse", "keyframes, relative RMSE", "", 4, false}, KeyframeRmse},
      {{"tracked_percent", "tracked", "%", 1, true}, TrackedShare},
      {{"keyframes", "keyframes", "", 0, false, false}, [](const json& s) { return At(s, "keyframes"); }},
      {{"loops", "loops", "", 0, true, false}, [](const json& s) { return At(s, "loops"); }},
      {{"vo_ms", "odometry", "ms a frame", 1, false}, [](const json& s) { return At(s, "stage_ms/total/median"); }},
      {{"vo_p95_ms", "odometry, 95 %", "ms a frame", 1, false},
       [](const json& s) { return At(s, "stage_ms/total/p95"); }},
      {{"cpu_ms", "CPU", "ms a frame", 1, false},
       [](const json& s) { return SumOverProcesses(s, "cpu_ms_per_frame"); }},
      {{"memory_mb", "memory", "MB", 0, false}, [](const json& s) { return SumOverProcesses(s, "peak_memory_mb"); }},
      {{"wall_s", "run", "s", 1, false}, [](const json& s) { return At(s, "wall_s"); }}};
  return kRows;
}

/// Names of inputs and outputs that do not influence the result or belong to the dataset, by the last part of an option's
/// name.
bool IsIncidental(const std::string& name) {
  static const std::array<const char*, 13> kEnds{
      ".dataset", ".kind",     ".out",           ".seed",        ".drop_seed",  ".file",        ".load",
      ".save",    ".map_file", ".overlay_every", ".history_dir", ".state_file", ".resume_after"};
  return std::any_of(kEnds.begin(), kEnds.end(), [&](const char* end) { return name.ends_with(end); });
}

void Flatten(const json& value, const std::string& name, std::map<std::string, std::string>& options) {
  if (value.is_object()) {
    for (const auto& [key, member] : value.items())
      Flatten(member, name.empty() ? key : fmt::format("{}.{}", name, key), options);
  } else if (!IsIncidental(name)) {
    options[name] = value.is_string() ? value.get<std::string>() : value.dump();
  }
}

std::map<std::string, std::string> OptionsOf(const json& summary) {
  std::map<std::string, std::string> options;
  std::string processes;
  const json configuration = summary.value("configuration", json::object());
  for (const auto& [process, sections] : configuration.items()) {
    // The viewer and the bus options do not influence the result.
    if (process == process_name::kViewer || !sections.is_object()) continue;
    if (!process_name::SendsFrames(process)) processes += (processes.empty() ? "" : "+") + process;
    for (const auto& [section, values] : sections.items()) {
      if (section != kBusSection) Flatten(values, section, options);
    }
  }
  options[kProcesses] = processes;
  options["version"] = summary.value("version", "");
  return options;
}

/// "synthetic:room?rate=10&seed=2&size=376x240" without "seed=2&".
std::string WithoutSeed(const std::string& dataset) {
  const size_t question = dataset.find('?');
  if (!dataset.starts_with("synthetic:") || question == std::string::npos) return dataset;
  std::string kept, rest = dataset.substr(question + 1);
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('&'), rest.size());
    const std::string option = rest.substr(0, end);
    if (!option.starts_with("seed=")) kept += (kept.empty() ? "?" : "&") + option;
    rest = end < rest.size() ? rest.substr(end + 1) : "";
  }
  return dataset.substr(0, question) + kept;
}

/// Returns the path without links and ".."; the name of a dataset that is no file.
std::filesystem::path CanonicalPath(const std::string& name) {
  std::error_code unknown;
  return std::filesystem::weakly_canonical(name, unknown);
}

}  // namespace

std::string NameWithUnit(const Metric& metric) {
  return metric.unit.empty() ? metric.name : fmt::format("{} [{}]", metric.name, metric.unit);
}

const std::vector<Metric>& Metrics() {
  static const std::vector<Metric> kMetrics = [] {
    std::vector<Metric> metrics;
    for (const MetricRow& row : Rows()) metrics.push_back(row.metric);
    return metrics;
  }();
  return kMetrics;
}

RunRecord RecordOf(const json& summary, const std::string& folder) {
  RunRecord record;
  record.folder = folder;
  record.played = summary.value("dataset", "");
  record.dataset = WithoutSeed(record.played);
  record.recordings = summary.value("recordings", std::vector<std::string>());
  record.completed = summary.value("completed", false);
  record.untracked = IsUntracked(summary);
  record.reason = summary.value("reason", "");
  record.options = OptionsOf(summary);
  for (const MetricRow& row : Rows()) record.values.push_back(row.read(summary));
  return record;
}

void ResolveRecordings(std::vector<RunRecord>* runs) {
  const auto recorded_by = [&](const std::string& played) -> const RunRecord* {
    const std::filesystem::path wanted = CanonicalPath(played);
    for (const RunRecord& run : *runs) {
      for (const std::string& recording : run.recordings) {
        if (CanonicalPath(recording) == wanted) return &run;
      }
    }
    return nullptr;
  };
  for (RunRecord& run : *runs) {
    const RunRecord* origin = recorded_by(run.played);
    // A recording may be of a replay, too.
    for (size_t i = 0; origin != nullptr && origin != &run && i < runs->size(); ++i) {
      run.played = origin->played;
      run.dataset = origin->dataset;
      origin = recorded_by(run.played);
    }
  }
}

std::optional<RunRecord> FindRunRecord(const std::string& folder) {
  if (!std::filesystem::is_directory(folder)) return std::nullopt;
  try {
    const std::optional<json> summary = ReadRun(folder, run_content::kSummary).summary;
    if (!summary || !summary->contains("completed") || !summary->contains("frames")) return std::nullopt;
    return RecordOf(*summary, folder);
  } catch (const json::exception&) {
    return std::nullopt;
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

}  // namespace plslam::evaluate
