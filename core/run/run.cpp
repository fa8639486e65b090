// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/run.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "core/errors/error_text.h"
#include "core/files/text_rows.h"
#include "core/run/result_files.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Returns the map of the folder; empty if there is none.
std::string FindMap(const std::string& folder) {
  std::vector<std::string> maps;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".plmap") maps.push_back(entry.path());
  }
  std::sort(maps.begin(), maps.end());
  if (maps.size() > 1) {
    throw std::runtime_error(
        fmt::format("{}: has {} maps: give one of them, such as {}", folder, maps.size(), maps.front()));
  }
  return maps.empty() ? "" : maps.front();
}

/// Returns an object, or a discarded value if the file is none.
json Parse(std::ifstream file) {
  json summary = json::parse(file, nullptr, false);
  return summary.is_object() ? summary : json(json::value_t::discarded);
}

json ReadSummary(const std::string& path) {
  json summary = Parse(OpenInput(path));
  if (summary.is_discarded()) throw std::runtime_error(path + ": is not readable as JSON");
  return summary;
}

/// The sessions of a run are in its map, unless it has only localised. Folders without a summary, and of earlier
/// versions, do not tell.
void CheckIsMapOfRun(const Run& run) {
  const json summary =
      run.summary ? *run.summary : Parse(std::ifstream(fs::path(run.folder) / result_file::kSummary));
  if (summary.is_discarded() || !summary.contains("sessions") || !summary["sessions"].is_array()) return;
  const json::json_pointer localises("/configuration/mapping/mapping/localise_only");
  if (summary["sessions"].empty() || (summary.contains(localises) && summary[localises] == true)) return;
  const bool is_of_run = std::ranges::any_of(summary["sessions"], [&](const json& session) {
    const auto* name = session.get_ptr<const std::string*>();
    const auto is_same = [&](const auto& of_map) {
      return name != nullptr && *name == std::to_string(of_map.first.value);
    };
    return std::ranges::any_of(run.map->sessions, is_same);
  });
  if (is_of_run) return;
  throw std::runtime_error(fmt::format(
      "{}: is of another run than the results in {}: name the map of that run, or move this one elsewhere",
      run.map_path, run.folder));
}

Trajectory ReadTum(const std::string& path) { return ReadTrajectory(path, TrajectoryFormat::kTum); }

FrameTable ReadFrameTable(const std::string& path) {
  FrameTable table;
  ForEachRow(path, [&](const TextRow& row) {
    std::vector<std::string> values(row.fields.begin(), row.fields.end());
    if (table.columns.empty()) {
      table.columns = std::move(values);
    } else if (values.size() != table.columns.size() || values.size() <= FrameTable::kState) {
      row.Fail("does not have the columns of the first line");
    } else {
      table.rows.push_back({row.Scaled(FrameTable::kTime, 9), std::move(values)});
    }
  });
  return table;
}

void ReadFolder(Run& run, unsigned content) {
  const auto read = [&](unsigned of, const char* name, const auto& reader, auto& value) {
    const fs::path path = fs::path(run.folder) / name;
    if ((content & of) != 0 && fs::is_regular_file(path)) value = reader(path.string());
  };
  read(run_content::kSummary, result_file::kSummary, ReadSummary, run.summary);
  read(run_content::kTrajectory, result_file::kTrajectory.tum, ReadTum, run.trajectory);
  read(run_content::kLive, result_file::kLiveTrajectory, ReadTum, run.live);
  read(run_content::kKeyframes, result_file::kKeyframes.tum, ReadTum, run.keyframes);
  read(run_content::kTruth, result_file::kTruth, ReadTum, run.truth);
  read(run_content::kCovariances, result_file::kCovariances, ReadPoseCovariances, run.covariance);
  read(run_content::kCovariances, result_file::kMotionCovariances, ReadPoseCovariances, run.motion_covariance);
  read(run_content::kFrames, result_file::kFrameTable, ReadFrameTable, run.frames);
}

}  // namespace

Run ReadRun(const std::string& path, unsigned content, const std::string& map) {
  if (!fs::exists(path)) throw std::runtime_error(fmt::format("{}: file or folder does not exist", path));
  Run run;
  if (!fs::is_directory(path)) {
    run.map_path = path;
    run.map = ReadMapFile(path);
    return run;
  }
  run.folder = path;
  const bool wants_map = (content & run_content::kMap) != 0;
  if (wants_map) run.map_path = map.empty() ? FindMap(path) : map;
  ReadFolder(run, content);
  if (wants_map && (content & run_content::kTrajectory) != 0 && run.map_path.empty() && !run.has_poses()) {
    throw std::runtime_error(
        fmt::format("{}: has neither a map (.plmap) nor a {} with poses in it", path, result_file::kTrajectory.tum));
  }
  if (run.map_path.empty()) return run;
  run.map = ReadMapFile(run.map_path);
  CheckIsMapOfRun(run);
  return run;
}

}  // namespace plslam
