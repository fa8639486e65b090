// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/export_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/bus/logs/log_reader.h"
#include "core/datasets/log_dataset.h"
#include "core/datasets/open_dataset.h"
#include "core/files/atomic_file.h"
#include "core/io/images/png_codec.h"
#include "core/io/maps/map_camera.h"
#include "core/io/maps/map_ply.h"
#include "core/map/map_parts.h"
#include "core/run/node/logged_run.h"
#include "core/run/result_files.h"
#include "core/run/run.h"
#include "tools/export/colmap.h"
#include "tools/export/keyframe_images.h"
#include "tools/export/map_obj.h"
#include "tools/export/mcap/export_mcap.h"
#include "tools/export/picture_check.h"
#include "tools/export/surface_files.h"
#include "tools/pose_graph/export.h"

namespace plslam::exports {
namespace {

/// Contents of a run that its messages have besides the map.
constexpr unsigned kTables = run_content::kTrajectory | run_content::kLive | run_content::kTruth |
                             run_content::kCovariances | run_content::kFrames;

/// State of an export while files are written.
struct OngoingExport {
  Run run;
  std::string out;
  std::shared_ptr<const Dataset> dataset;
  std::unique_ptr<KeyframeImages> images;
  std::vector<ExportedFile> files;
  std::optional<ColmapModel> model;

  const Map& map() const { return run.map->map; }
  std::string Path(const std::string& name) const { return out + "/" + name; }
  void AddFile(const std::string& name, const std::string& what) { files.push_back({Path(name), what}); }
};

void ExportPly(OngoingExport& e) {
  WriteFileAtomically(e.Path(result_file::kLandmarks), MapPly(e.map()));
  e.AddFile(result_file::kLandmarks,
            fmt::format("{} points, {} lines", e.map().points().size(), e.map().lines().size()));
}

void ExportObj(OngoingExport& e) {
  WriteFileAtomically(e.Path("map.obj"), MapObj(e.map()));
  e.AddFile("map.obj", fmt::format("{} points, {} lines, the path of {} keyframes", e.map().points().size(),
                                   e.map().lines().size(), e.map().keyframes().size()));
}

std::string ModelText(const ColmapModel& model) {
  return fmt::format("{} images, {} points", model.images.size(), model.points.size());
}

/// Made once: two formats write it.
const ColmapModel& ModelOf(OngoingExport& e) {
  if (!e.model) e.model = ColmapOf(*e.run.map, MapCamera(*e.run.map, e.run.map_path));
  return *e.model;
}

/// The images of the model, where the dataset has them.
void ExportImages(OngoingExport& e) {
  const std::string folder = e.Path("colmap/images");
  std::filesystem::create_directories(folder);
  size_t n = 0, n_others = 0;
  const auto names = KeyframeImageNames(e.map());
  const KeyframeFeatures& all_features = e.run.map->features;
  for (const auto& [id, keyframe] : e.map().keyframes()) {
    const auto image = e.images->At(keyframe.t_ns);
    if (!image) continue;
    const auto features = all_features.find(id);
    // Another camera's keyframe has its own image.
    const bool is_of_dataset =
        features == all_features.end() || (!features->second.image && ShowsKeyframe(*image, features->second));
    if (!is_of_dataset) {
      ++n_others;
      continue;
    }
    WritePng(folder + "/" + names.at(id), *image);
    ++n;
  }
  e.AddFile("colmap/images",
            fmt::format("{} of {} rectified images of keyframes{}", n, names.size(),
                        n_others == 0 ? "" : fmt::format("; {} keyframes are of another dataset", n_others)));
}

void ExportColmap(OngoingExport& e) {
  const ColmapModel& model = ModelOf(e);
  WriteColmapBinary(e.Path("colmap/sparse"), model);
  e.AddFile("colmap/sparse", ModelText(model));
  if (e.images) ExportImages(e);
}

void ExportColmapText(OngoingExport& e) {
  const ColmapModel& model = ModelOf(e);
  WriteColmapText(e.Path("colmap/text"), model);
  e.AddFile("colmap/text", ModelText(model));
}

void ExportG2o(OngoingExport& e) {
  const pose_graph::G2oGraph<SE3> graph = pose_graph::G2oOf(e.map());
  pose_graph::WriteG2o(e.Path("pose_graph.g2o"), graph);
  e.AddFile("pose_graph.g2o", fmt::format("{} poses, {} edges", graph.graph.poses.size(), graph.graph.edges.size()));
}

void WriteTimes(const std::string& path, const Trajectory& trajectory) {
  std::string text;
  for (const TrajectoryPose& pose : trajectory) text += SecondsText(pose.t_ns) + "\n";
  WriteFileAtomically(path, text);
}

void WritePoses(const std::string& name, TrajectoryFormat format, const Trajectory& trajectory,
                const std::string& what, OngoingExport& e) {
  const std::string file = name + (format == TrajectoryFormat::kTum     ? ".tum"
                                   : format == TrajectoryFormat::kKitti ? ".kitti"
                                                                        : ".euroc");
  WriteTrajectory(e.Path(file), format, trajectory);
  e.AddFile(file, fmt::format("{} {}", trajectory.size(), what));
  if (format != TrajectoryFormat::kKitti) return;
  WriteTimes(e.Path(name + "_times.txt"), trajectory);
  e.AddFile(name + "_times.txt", "its times, in seconds");
}

void ExportPoses(TrajectoryFormat format, OngoingExport& e) {
  if (e.run.has_poses()) WritePoses("trajectory", format, *e.run.trajectory, "frames", e);
  if (!e.run.map || e.map().keyframes().empty()) return;
  const SE3 T_c_l = e.images ? e.images->T_l_c().Inverse() : SE3();
  for (auto& [suffix, keyframes] : pose_graph::TrajectoriesOf(e.map())) {
    for (TrajectoryPose& pose : keyframes) pose.T_a_b = pose.T_a_b * T_c_l;
    WritePoses("keyframes" + suffix, format, keyframes, "keyframes", e);
  }
}

void ExportAsMcap(OngoingExport& e) {
  const McapContent content = ExportMcap(e.run, e.dataset.get(), e.Path("run.mcap"));
  e.AddFile("run.mcap", fmt::format("{} frames, {} images{}{}{}", content.frames, content.images,
                                    content.has_map ? ", the map" : "", content.has_grid ? ", the grid" : "",
                                    content.has_surfaces ? ", the surfaces" : ""));
  WriteFileAtomically(e.Path("foxglove_layout.json"), FoxgloveLayout());
  e.AddFile("foxglove_layout.json", "layout for Foxglove and Lichtblick: Layouts, Import from file");
}

struct Writer {
  ExportFormat format;
  void (*write)(OngoingExport&);  ///< nullptr: written with all others that need surfaces (ExportSurfaces)
};

const std::vector<Writer>& Writers() {
  static const std::vector<Writer> kWriters{
      {{"ply", "points and lines, binary (CloudCompare, MeshLab)", true}, ExportPly},
      {{"obj", "points, lines and the path of the keyframes, text (Blender, MeshLab)", true}, ExportObj},
      {{"colmap", "COLMAP's model, binary, and the images if there is a dataset", true, true}, ExportColmap},
      {{"colmap-text", "the same model as text", true, true}, ExportColmapText},
      {{"g2o", "pose graph", true}, ExportG2o},
      {{"tum", "poses: t tx ty tz qx qy qz qw", false},
       [](OngoingExport& e) { ExportPoses(TrajectoryFormat::kTum, e); }},
      {{"kitti", "poses: rows of [R t]; and their times", false},
       [](OngoingExport& e) { ExportPoses(TrajectoryFormat::kKitti, e); }},
      {{"euroc", "poses: t_ns,px,py,pz,qw,qx,qy,qz", false},
       [](OngoingExport& e) { ExportPoses(TrajectoryFormat::kEuroc, e); }},
      {{"mcap", "messages of ROS 2 (Foxglove, Lichtblick, Rerun, ros2 bag), and a layout", false}, ExportAsMcap},
      {{"cloud", "points of the surfaces, PLY (maps saved with --dense)", true, true, true}, nullptr},
      {{"mesh", "the surfaces as triangles, PLY", true, true, true}, nullptr},
      {{"mesh-obj", "the same mesh as text, OBJ with colours (Blender, MeshLab)", true, true, true}, nullptr},
      {{"octomap", "free and occupied voxels for OctoMap (map.bt, map.ot)", true, true, true}, nullptr},
      {{"grid", "grid of the floor for nav2 (map.pgm, map.yaml), distances, heights and the path", true, true, true},
       nullptr}};
  return kWriters;
}

bool IsNamed(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void CheckNames(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto& all = Writers();
    if (std::none_of(all.begin(), all.end(), [&](const Writer& w) { return w.format.name == name; })) {
      throw std::runtime_error(fmt::format("'{}' is not an export format", name));
    }
  }
}

LoggedRun ReadLog(const std::string& log, OngoingExport& e) {
  namespace fs = std::filesystem;
  const std::string folder = e.Path("run");
  if (fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder))) {
    throw std::runtime_error(fmt::format(
        "{}: already exists, and the files of the run would be written there: remove it, or give another --out",
        folder));
  }
  LoggedRun logged = ReadLoggedRun(log);
  if (logged.has_frames && !e.dataset) {
    e.dataset = bus::OpenLogDataset(log, logged.prefix);
    PrintNotes(*e.dataset);
  }
  e.run = RunOf(logged);
  e.run.map_path = log;
  const auto& lacks = e.run.notes.warnings;
  e.AddFile("run", fmt::format("trajectories and tables of the log{}",
                               lacks.empty() ? "" : fmt::format(" ({})", fmt::join(lacks, "; "))));
  return logged;
}

bool Has(const OngoingExport& e, const ExportFormat& format) {
  if (format.needs_surfaces && !HasSurfaces(e.run.map_path)) return false;
  return !format.needs_map || (e.run.map && (!e.run.map->features.empty() || !format.needs_features));
}

void CheckContent(const ExportRequest& request, const OngoingExport& e) {
  for (const ExportFormat& format : ExportFormats()) {
    if (!IsNamed(request.formats, format.name) || Has(e, format)) continue;
    if (format.needs_surfaces) {
      throw std::runtime_error(fmt::format(
          "{}: {} needs the surfaces of a saved map: plslam run --dense --save-map FILE.plmap writes them beside it",
          request.source, format.name));
    }
    throw std::runtime_error(fmt::format("{}: {} needs a {}map: plslam run --save-map FILE.plmap writes one",
                                         request.source, format.name, format.needs_features ? "saved " : ""));
  }
}

bool IsWanted(const ExportRequest& request, const OngoingExport& e, const ExportFormat& format) {
  return request.formats.empty() ? Has(e, format) : IsNamed(request.formats, format.name);
}

void WriteFormats(const ExportRequest& request, OngoingExport& e) {
  for (const auto& [format, write] : Writers()) {
    if (write != nullptr && IsWanted(request, e, format)) write(e);
  }
}

/// The surfaces are read and merged once for all their formats, and for all parts of a map.
void ExportSurfaces(const ExportRequest& request, OngoingExport& e) {
  std::vector<std::string> kinds;
  for (const ExportFormat& format : ExportFormats()) {
    if (format.needs_surfaces && IsWanted(request, e, format)) kinds.push_back(format.name);
  }
  if (kinds.empty()) return;
  for (const std::string& name : WriteSurfaceFiles(e.run.map_path, request.out, kinds)) {
    const bool is_frames = name == result_file::kSurfaceFrames;
    e.files.push_back({request.out + "/" + name,
                       is_frames ? "frames of the surfaces" : "of the surfaces of the map (docs/planning.md)"});
  }
}

/// Adds the formats that were not named and need a map that is not there.
void AddLeftOut(const ExportRequest& request, OngoingExport& e) {
  if (!request.formats.empty()) return;
  std::vector<std::string> names;
  for (const ExportFormat& format : ExportFormats()) {
    if (!format.needs_surfaces && !Has(e, format)) names.push_back(format.name);
  }
  if (names.empty()) return;
  e.files.push_back({"left out", fmt::format("{}: there is no {}map (plslam run --save-map FILE.plmap writes one)",
                                             fmt::join(names, ", "), e.run.map ? "saved " : "")});
}

Run MapOnly(Run run) {
  Run only;
  only.map_path = std::move(run.map_path);
  only.map = std::move(run.map);
  return only;
}

/// The main part of the map is that of the frames. Each other part has a frame and a folder of its own.
void WriteParts(const ExportRequest& request, OngoingExport& e) {
  if (!e.run.map) return WriteFormats(request, e);
  std::set<int64_t> times_ns;
  if (e.run.trajectory) {
    for (const TrajectoryPose& pose : *e.run.trajectory) times_ns.insert(pose.t_ns);
  }
  const auto parts = PartsOf(e.map(), [&](const MapKeyframe& keyframe) { return times_ns.contains(keyframe.t_ns); });
  if (parts.size() < 2) return WriteFormats(request, e);
  const Map whole = e.map();
  for (size_t i = 0; i < parts.size(); ++i) {
    e.run.map->map = PartOf(whole, parts[i]);
    e.model.reset();
    if (i > 0) {
      e.run = MapOnly(std::move(e.run));
      e.out = fmt::format("{}/part{}", request.out, i + 1);
      MakeFolder(e.out);
      e.files.push_back({e.out, fmt::format("{} keyframes that are not connected with those before, in a frame of "
                                            "their own",
                                            parts[i].size())});
    }
    WriteFormats(request, e);
  }
}

}  // namespace

const std::vector<ExportFormat>& ExportFormats() {
  static const std::vector<ExportFormat> kFormats = [] {
    std::vector<ExportFormat> formats;
    for (const Writer& writer : Writers()) formats.push_back(writer.format);
    return formats;
  }();
  return kFormats;
}

std::vector<ExportedFile> ExportRun(const ExportRequest& request) {
  CheckNames(request.formats);
  OngoingExport e;
  e.out = request.out;
  if (!request.dataset.empty()) e.dataset = OpenDatasetAndWarn(request.dataset, "");
  std::optional<LoggedRun> logged;
  if (bus::LooksLikeLcmLog(request.source)) {
    logged = ReadLog(request.source, e);
  } else {
    const bool has_mcap = request.formats.empty() || IsNamed(request.formats, "mcap");
    e.run = ReadRun(request.source, run_content::kMap | (has_mcap ? kTables : run_content::kTrajectory));
  }
  CheckContent(request, e);
  if (e.dataset && e.run.map) {
    const StereoCamera camera = MapCamera(*e.run.map, e.run.map_path);
    e.images = std::make_unique<KeyframeImages>(e.dataset, camera);
  }
  MakeFolder(request.out);
  WriteParts(request, e);
  ExportSurfaces(request, e);
  AddLeftOut(request, e);
  if (logged) WriteLoggedRun(*logged, request.out + "/run");
  return e.files;
}

}  // namespace plslam::exports
