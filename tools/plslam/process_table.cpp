// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/process_table.h"

#include <fmt/format.h>
#include <unistd.h>

#include "core/run/process_names.h"

namespace plslam::launcher {
namespace {

using Arguments = std::vector<std::string>;

using process_name::kCamera;
using process_name::kDense;
using process_name::kLoop;
using process_name::kMapping;
using process_name::kPlayer;
using process_name::kRos2;
using process_name::kViewer;
using process_name::kVo;

bool Always(const RunOptions&) { return true; }
bool WithMap(const RunOptions& options) { return !options.no_mapping; }
bool WithLoops(const RunOptions& options) { return !options.no_mapping && !options.no_loops; }
bool OwnMap(const RunOptions& options) { return WithMap(options) && options.map_prefix.empty(); }
bool OwnLoops(const RunOptions& options) { return WithLoops(options) && options.map_prefix.empty(); }
bool FromCameras(const RunOptions& options) { return options.from_cameras; }
bool FromRos2(const RunOptions& options) { return options.from_ros2; }
bool FromDataset(const RunOptions& options) { return !options.from_cameras && !options.from_ros2; }
bool WithSurfaces(const RunOptions& options) { return options.dense; }
bool Recorded(const RunOptions& options) { return !options.record.empty(); }

/// The launcher has checked whether the file may be replaced.
Arguments RecorderArguments(const RunOptions& options) { return {"--force", RecordingOf(options, 0).string()}; }

/// "--set section.key=value" for each option that was given.
class Settings {
 public:
  explicit Settings(const std::string& section) : section_(section) {}

  void Add(const std::string& key, const std::string& value) {
    if (!value.empty()) arguments_.insert(arguments_.end(), {"--set", section_ + "." + key + "=" + value});
  }
  void Add(const std::string& key, int64_t value) {
    if (value >= 0) Add(key, std::to_string(value));
  }
  void Add(const std::string& key, bool value) {
    if (value) Add(key, std::string("true"));
  }
  Arguments Take() { return std::move(arguments_); }

 private:
  std::string section_;
  Arguments arguments_;
};

Arguments ViewerArguments(const RunOptions& options) {
  Settings settings(kViewer);
  settings.Add("out", std::filesystem::absolute(options.out).string());
  settings.Add("overlay_every", options.overlay_every);
  settings.Add("serve", options.serve);
  if (!options.video.empty()) settings.Add("video", std::filesystem::absolute(options.video).string());
  return settings.Take();
}

Arguments DenseArguments(const RunOptions& options) {
  Settings settings(kDense);
  settings.Add("out", std::filesystem::absolute(options.out).string());
  if (options.map.empty()) return settings.Take();
  const std::string surfaces = std::filesystem::absolute(options.map).string() + ".surfaces";
  if (std::filesystem::exists(surfaces)) settings.Add("map_file", surfaces);
  return settings.Take();
}

Arguments VoArguments(const RunOptions& options) {
  Settings settings(kVo);
  settings.Add("features.features", options.features);
  if (options.no_mapping) settings.Add("map.enabled", std::string("false"));
  if (!WithLoops(options)) settings.Add("relocalisation.enabled", std::string("false"));
  settings.Add("map.localise_only", options.localise_only);
  return settings.Take();
}

Arguments MappingArguments(const RunOptions& options) {
  Settings settings(kMapping);
  if (options.no_loops) settings.Add("loops.enabled", std::string("false"));
  if (!options.map.empty()) settings.Add("map_file", std::filesystem::absolute(options.map).string());
  settings.Add("localise_only", options.localise_only);
  return settings.Take();
}

// With few processors, the process that the others wait for comes first. In lockstep that is mapping_process: each
// keyframe waits for the adjustment after the previous one; the tracker and the viewer, which draws pictures of each
// frame, come next. Live it is the tracker, together with mapping_process; no process waits for the others.
constexpr Niceness kFirst{0, 0};
constexpr Niceness kFirstWhenLive{5, 0};
constexpr Niceness kSourceOfFrames{8, 0};
constexpr Niceness kStandsBack{8, 8};
constexpr Niceness kDrawsPictures{5, 10};

Arguments NoArguments(const RunOptions&) { return {}; }

Arguments PlayerArguments(const RunOptions& options) {
  Settings settings(kPlayer);
  settings.Add("dataset", options.dataset);
  settings.Add("kind", options.kind);
  settings.Add("pace", options.pace);
  settings.Add("start", options.start);
  settings.Add("stop", options.stop);
  settings.Add("stride", options.stride);
  settings.Add(kLoop, options.loop);
  settings.Add("bounce", options.bounce);
  settings.Add("skip_bad", options.skip_bad);
  return settings.Take();
}

Arguments CameraArguments(const RunOptions& options) {
  Settings settings(kCamera);
  settings.Add("rig", options.dataset);
  settings.Add("pace", options.pace);
  return settings.Take();
}

Arguments Ros2Arguments(const RunOptions& options) {
  const std::string topics = options.dataset.substr(kRos2Prefix.size());
  const size_t comma = topics.find(',');
  Settings settings(kRos2);
  settings.Add("left", topics.substr(0, comma));
  settings.Add("right", topics.substr(comma + 1));
  return settings.Take();
}

Arguments CommonArguments(const RunOptions& options) {
  Arguments arguments = {"--url", options.url, "--parent", std::to_string(getpid())};
  if (options.own_bus) arguments.emplace_back("--own-bus");
  if (!options.prefix.empty()) arguments.insert(arguments.end(), {"--prefix", options.prefix});
  if (!options.map_prefix.empty()) {
    arguments.insert(arguments.end(), {"--map-prefix", options.map_prefix});
  }
  if (!options.config_file.empty()) {
    arguments.insert(arguments.end(), {"--config", std::filesystem::absolute(options.config_file).string()});
  }
  for (const std::string& assignment : options.overrides) arguments.insert(arguments.end(), {"--set", assignment});
  return arguments;
}

constexpr ProcessRow kTable[] = {
    {process_name::kRecorder, "plslam", "records all traffic in an LCM event log (--record)",
     Supervisor::Ending::kWritesAtTheEnd, false, Recorded, kFirst, RecorderArguments},
    {kViewer, "viewer_headless", "progress, trajectories, map file and pictures", Supervisor::Ending::kWritesAtTheEnd,
     false, Always, kDrawsPictures, ViewerArguments},
    {kMapping, "mapping_process", "mapping: keyframes, points and lines, local bundle adjustment",
     Supervisor::Ending::kRestart, false, OwnMap, kFirst, MappingArguments},
    {kLoop, "loop_process", "place recognition: loop closing and relocalisation", Supervisor::Ending::kRestart, false,
     OwnLoops, kStandsBack, NoArguments},
    {kDense, "dense_process", "surfaces for planning: mesh, OctoMap and grid (--dense)",
     Supervisor::Ending::kWritesAtTheEnd, false, WithSurfaces, kStandsBack, DenseArguments},
    {kVo, "vo_process", "stereo odometry with points and lines", Supervisor::Ending::kRestart, false, Always,
     kFirstWhenLive, VoArguments},
    {kPlayer, "player", "datasets and synthetic worlds to stereo frames", Supervisor::Ending::kMayEnd, true,
     FromDataset, kSourceOfFrames, PlayerArguments},
    {kCamera, "camera", "live cameras to stereo frames", Supervisor::Ending::kMayEnd, true, FromCameras, kFirst,
     CameraArguments},
    {kRos2, "plslam_ros2", "a robot of ROS 2 to stereo frames", Supervisor::Ending::kMayEnd, true, FromRos2, kFirst,
     Ros2Arguments},
};

}  // namespace

std::span<const ProcessRow> ProcessTable() { return kTable; }

std::string_view TitleOf(const ProcessRow& row) {
  return row.name == process_name::kRecorder ? row.name : row.executable;
}

const char* SourceOfFrames(const RunOptions& options) {
  if (options.from_ros2) return kRos2;
  return options.from_cameras ? kCamera : kPlayer;
}

int NicenessOf(const ProcessRow& row, const RunOptions& options) {
  return options.pace.starts_with(stream_pace::kRealtime) ? row.niceness.live : row.niceness.lockstep;
}

std::filesystem::path StateFileOf(const RunOptions& options, const std::string& process) {
  return std::filesystem::absolute(options.out / fmt::format(".{}_state", process));
}

std::filesystem::path RecordingOf(const RunOptions& options, int restart) {
  std::filesystem::path file = std::filesystem::absolute(options.record);
  if (restart > 0) file += fmt::format(".{}", restart + 1);
  return file;
}

std::vector<std::string> ArgumentsOf(const ProcessRow& row, const RunOptions& options) {
  Arguments arguments;
  if (row.name == process_name::kRecorder) arguments.emplace_back("record");
  if (row.name == kVo || row.name == kMapping || row.name == kDense) {
    const std::string name(row.name);
    arguments.emplace_back("--set");
    arguments.push_back(fmt::format("{}.state_file={}", name, StateFileOf(options, name).string()));
  }
  for (std::string& common : CommonArguments(options)) arguments.push_back(std::move(common));
  for (std::string& own : row.arguments(options)) arguments.push_back(std::move(own));
  return arguments;
}

std::vector<std::string> ArgumentsOfRestart(const RunOptions& options, const Restart& restart,
                                            std::vector<std::string> arguments) {
  if (restart.name == process_name::kRecorder) arguments.back() = RecordingOf(options, restart.number).string();
  // A robot is not resumed where it was: it sends what it sees now.
  const bool resumes = process_name::SendsFrames(restart.name) && restart.name != kRos2;
  if (resumes && restart.newest_frame.first >= 0) {
    arguments.emplace_back("--set");
    arguments.push_back(
        fmt::format("{}.resume_after={}@{}", restart.name, restart.newest_frame.first, restart.newest_frame.second));
  }
  if (resumes && restart.paused) {
    arguments.emplace_back("--set");
    arguments.push_back(fmt::format("{}.paused=true", restart.name));
  }
  return arguments;
}

}  // namespace plslam::launcher
