// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/run_source.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/io/maps/map_camera.h"

namespace plslam::exports {
namespace {

namespace fs = std::filesystem;

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

/// The sessions of a run are in its map, unless it has only localised. Folders without a summary, and of earlier versions,
/// do not tell.
void CheckIsMapOfRun(const RunSource& source) {
  std::ifstream file(fs::path(source.folder) / "summary.json");
  const nlohmann::json summary = nlohmann::json::parse(file, nullptr, false);
  if (!summary.is_object() || !summary.contains("sessions") || !summary["sessions"].is_array()) return;
  const nlohmann::json::json_pointer localises("/configuration/mapping/mapping/localise_only");
  if (summary["sessions"].empty() || (summary.contains(localises) && summary[localises] == true)) return;
  const nlohmann::json& sessions = summary["sessions"];
  const bool is_of_run = std::any_of(sessions.begin(), sessions.end(), [&](const nlohmann::json& session) {
    const auto of_map = [&](const auto& entry) { return session == std::to_string(entry.first); };
    return std::ranges::any_of(source.map->sessions, of_map);
  });
  if (is_of_run) return;
  throw std::runtime_error(fmt::format(
      "{}: is of another run than the results in {}: name the map of that run, or move this one elsewhere",
      source.map_path, source.folder));
}

}  // namespace

RunSource ReadRunSource(const std::string& path, const std::string& map) {
  RunSource source;
  if (!fs::exists(path)) throw std::runtime_error(fmt::format("{}: file or folder does not exist", path));
  if (!fs::is_directory(path)) {
    source.map_path = path;
  } else {
    source.folder = path;
    source.map_path = map.empty() ? FindMap(path) : map;
    const std::string frames = (fs::path(path) / "trajectory.tum").string();
    if (fs::exists(frames)) source.frames = ReadTrajectory(frames, TrajectoryFormat::kTum);
    if (source.map_path.empty() && source.frames.empty()) {
      throw std::runtime_error(
          fmt::format("{}: has neither a map (.plmap) nor a trajectory.tum with poses in it", path));
    }
  }
  if (!source.map_path.empty()) source.map = ReadMapFile(source.map_path);
  if (source.map && !source.folder.empty()) CheckIsMapOfRun(source);
  return source;
}

KeyframeImages::KeyframeImages(std::shared_ptr<const Dataset> dataset, const StereoCamera& camera)
    : dataset_(std::move(dataset)) {
  rectifier_ = std::make_unique<Rectifier>(dataset_->rig());
  const std::string difference = CameraDifference(camera, rectifier_->camera());
  if (!difference.empty()) {
    throw std::runtime_error(
        fmt::format("{}: its rectified camera is not that of the map: {}", dataset_->name(), difference));
  }
  for (int i = 0; i < dataset_->size(); ++i) index_of_[dataset_->t_ns(i)] = i;
}

std::optional<cv::Mat> KeyframeImages::At(int64_t t_ns) const {
  const auto index = index_of_.find(t_ns);
  if (index == index_of_.end()) return std::nullopt;
  return rectifier_->RectifyLeft(dataset_->Read(index->second).left);
}

}  // namespace plslam::exports
