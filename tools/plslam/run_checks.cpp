// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_checks.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "camera/options.h"
#include "core/bus/options.h"
#include "core/config/config.h"
#include "core/datasets/recordings/recording_dataset.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/shared_file.h"
#include "core/io/maps/map_camera.h"
#include "core/io/maps/map_file.h"
#include "core/process/process_arguments.h"
#include "core/run/process_names.h"
#include "core/run/result_files.h"
#include "core/stream/pacing.h"
#include "player/options.h"
#include "tools/plslam/offline_commands.h"
#include "tools/plslam/process_table.h"

namespace plslam::launcher {
namespace {

using std::filesystem::path;

void CheckWritable(const char* option, const path& file) {
  if (std::filesystem::is_directory(file)) {
    throw std::runtime_error(fmt::format("{} {}: is a folder, not a file to write", option, file.string()));
  }
  const path folder = std::filesystem::absolute(file).parent_path();
  if (!std::filesystem::is_directory(folder)) {
    throw std::runtime_error(
        fmt::format("{} {}: the folder {} does not exist", option, file.string(), folder.string()));
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw std::runtime_error(
        fmt::format("{} {}: cannot be written: {}", option, file.string(), std::strerror(errno)));
  }
}

bool AreSame(const path& a, const path& b) {
  std::error_code no_such_file;
  return !b.empty() && std::filesystem::equivalent(a, b, no_such_file);
}

void CheckIsNot(const char* option, const path& file, const path& input) {
  if (!AreSame(file, input)) return;
  throw std::runtime_error(
      fmt::format("{} {}: this run reads that file and would overwrite it", option, file.string()));
}

void RemoveIfOld(const path& file, std::filesystem::file_time_type began) {
  std::error_code ignored;
  const auto written = std::filesystem::last_write_time(file, ignored);
  if (!ignored && written < began) std::filesystem::remove(file, ignored);
}

void RemoveOldFiles(const path& folder, const char* extension, std::filesystem::file_time_type began) {
  std::error_code no_folder;
  for (const auto& entry : std::filesystem::directory_iterator(folder, no_folder)) {
    if (entry.path().extension() == extension) RemoveIfOld(entry.path(), began);
  }
}

/// Any other name is that of a folder of pictures.
void CheckVideo(const path& video) {
  static const std::array<path, 9> kOtherFilms{".avi",  ".mkv", ".mov", ".webm", ".mpg",
                                               ".mpeg", ".m4v", ".gif", ".ogv"};
  if (std::ranges::find(kOtherFilms, path(video.extension())) != kOtherFilms.end()) {
    throw std::runtime_error(
        fmt::format("--video {}: films are MP4 files: give a name that ends in .mp4, or that of a "
                    "folder for pictures",
                    video.string()));
  }
  CheckWritable("--video", video);
}

}  // namespace

void CheckFilesToWrite(const RunOptions& options) {
  if (!options.video.empty()) CheckVideo(options.video);
  using File = std::pair<const char*, path>;
  for (const auto& [option, file] : {File("--record", options.record), File("--save-map", options.save_map)}) {
    if (file.empty()) continue;
    CheckWritable(option, file);
    CheckIsNot(option, file, FileOfLocation(options.dataset));
    CheckIsNot(option, file, options.config_file);
    if (file == options.record) CheckIsNot(option, file, options.map);
    // A map may be saved over the one that the run continues: it is replaced when it is complete.
    const bool continues = file == options.save_map && AreSame(file, options.map);
    if (options.force || continues || !std::filesystem::exists(file)) continue;
    throw std::runtime_error(
        fmt::format("{} {}: exists already; give another name, or --force to replace it", option, file.string()));
  }
}

void ReadConfiguration(RunOptions* options) {
  bus::ProcessArguments arguments;
  arguments.config_file = options->config_file;
  arguments.overrides = options->overrides;
  const Config config = arguments.MakeConfig();
  bus::BusOptions bus;
  player::PlayerOptions player;
  config.Read(kBusSection, bus);
  camera::CameraOptions camera;
  config.Read("player", player);
  config.Read("camera", camera);
  const auto take = [](std::string* option, const std::string& configured) {
    if (option->empty()) *option = configured;
  };
  take(&options->url, bus.url);
  take(&options->prefix, bus.prefix);
  take(&options->map_prefix, bus.map_prefix);
  take(&options->kind, player.kind);
  if (options->from_ros2) take(&options->pace, stream_pace::kRealtime);
  take(&options->pace, options->from_cameras ? camera.pace : player.pace);
  stream::ParsePace(options->pace);
  if (options->map_prefix.empty()) return;
  if (options->url.empty()) {
    throw std::runtime_error("bus.map_prefix: robots that share a map share a bus: give its --url or bus.url");
  }
  if (!options->map.empty() || !options->save_map.empty()) {
    throw std::runtime_error(
        "bus.map_prefix: --map and --save-map are for a map of this run only, and this map is shared");
  }
}

namespace {

/// Returns the "section.key=value" that options of `plslam run` give the process.
std::vector<std::string> SettingsOf(const ProcessRow& row, const RunOptions& options) {
  const std::vector<std::string> arguments = row.arguments(options);
  std::vector<std::string> settings;
  for (size_t i = 0; i + 1 < arguments.size(); ++i) {
    if (arguments[i] == "--set") settings.push_back(arguments[i + 1]);
  }
  return settings;
}

void CheckOverride(const std::string& assignment, const RunOptions& options) {
  const std::string section = assignment.substr(0, assignment.find('.'));
  if (std::ranges::find(process_name::kAll, section) == process_name::kAll.end()) return;
  const auto table = ProcessTable();
  const auto row = std::ranges::find_if(table, [&](const ProcessRow& other) { return other.name == section; });
  if (row == table.end() || !row->wanted(options)) {
    throw std::runtime_error(fmt::format("--set {}: this run starts no {} (`plslam processes`): remove the option",
                                         assignment, row == table.end() ? section : TitleOf(*row)));
  }
  const std::string key = assignment.substr(0, assignment.find('=') + 1);
  for (const std::string& setting : SettingsOf(*row, options)) {
    if (!setting.starts_with(key) || setting == assignment) continue;
    throw std::runtime_error(
        fmt::format("--set {}: the arguments of `plslam run` decide, with {}: remove this option, or change them",
                    assignment, setting));
  }
}

}  // namespace

void CheckOverrides(const RunOptions& options) {
  for (const std::string& assignment : options.overrides) CheckOverride(assignment, options);
}

void CheckMapToContinue(const RunOptions& options) {
  if (options.map.empty()) return;
  MapCamera(ReadMapFile(options.map.string()), options.map.string());
}

void CheckRefinement(RunOptions* options) {
  if (options->refine.empty()) return;
  CheckOfflineCommands();
  if (options->save_map.empty()) options->save_map = options->out / result_file::kMap;
  if (AreSame(options->save_map.parent_path(), options->out)) return;
  throw std::runtime_error(
      fmt::format("--refine: --save-map {} is not in the folder of the run, {}: the frames there "
                  "would not follow; leave --save-map out",
                  options->save_map.string(), options->out.string()));
}

void CheckSurfaces(const RunOptions& options) {
  if (!options.dense) return;
  const path program = ProgramFolder() / "dense_process";
  if (access(program.c_str(), X_OK) == 0) return;
  throw std::runtime_error(
      fmt::format("--dense: the program {} is missing: 'scripts/build release' builds it, with libopenvdb-dev and "
                  "liboctomap-dev",
                  program.string()));
}

namespace {

void CheckProgram(const RunOptions& options, const char* what, const char* program, const char* packages) {
  const path file = ProgramFolder() / program;
  if (access(file.c_str(), X_OK) == 0) return;
  throw std::runtime_error(
      fmt::format("{} names {}, and the program {} is missing: 'scripts/build release' builds it, with {}",
                  options.dataset, what, file.string(), packages));
}

void CheckRos2Topics(const std::string& dataset) {
  const std::string topics = dataset.substr(kRos2Prefix.size());
  const size_t comma = topics.find(',');
  const bool is_pair = comma != std::string::npos && comma > 0 && comma + 1 < topics.size() &&
                       topics.find(',', comma + 1) == std::string::npos;
  if (is_pair) return;
  throw std::runtime_error(fmt::format(
      "{}: names no two topics: ros2:/stereo/left/image_raw,/stereo/right/image_raw (`plslam topics ros2:` "
      "lists those of the robot)",
      dataset));
}

}  // namespace

void CheckLive(const RunOptions& options) {
  if (!options.from_cameras && !options.from_ros2) return;
  const char* const what = options.from_ros2 ? "a robot (ros2:)" : "cameras (source)";
  const std::pair<const char*, bool> of_datasets[] = {
      {"--kind", !options.kind.empty()}, {"--topics", !options.topics.empty()}, {"--start", options.start >= 0},
      {"--stop", options.stop >= 0},     {"--stride", options.stride >= 0},     {"--loop", options.loop >= 0},
      {"--bounce", options.bounce},      {"--skip-bad", options.skip_bad}};
  for (const auto& [option, is_given] : of_datasets) {
    if (!is_given) continue;
    throw std::runtime_error(fmt::format("{} is for datasets, and {} names {}", option, options.dataset, what));
  }
  if (options.from_ros2) {
    CheckRos2Topics(options.dataset);
    CheckProgram(options, what, "plslam_ros2",
                 "the package plslam-ros2 (or cyclonedds-dev, cyclonedds-tools and libfastrtps-dev)");
  } else {
    CheckProgram(options, what, process_name::kCamera, "libgstreamer1.0-dev and libgstreamer-plugins-base1.0-dev");
  }
}

std::filesystem::file_time_type FileTimeNow(const RunOptions& options) {
  const path marker = options.out / ".began";
  WriteFileAtomically(marker.string(), "");
  const auto now = std::filesystem::last_write_time(marker);
  std::filesystem::remove(marker);
  return now;
}

void RemoveOldOutputs(const RunOptions& options, std::filesystem::file_time_type began) {
  for (const char* name : kResultFiles) RemoveIfOld(options.out / name, began);
  RemoveOldFiles(options.out / "overlays", ".png", began);
  RemoveOldFiles(options.out / "logs", ".log", began);
  if (options.record.empty()) return;
  for (int restart = 1; restart <= options.max_restarts; ++restart) {
    RemoveIfOld(RecordingOf(options, restart), began);
  }
}

}  // namespace plslam::launcher
