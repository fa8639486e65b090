// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/tum_dataset.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <string_view>
#include <utility>

#include "core/datasets/camera_file.h"
#include "core/datasets/dataset_rows.h"
#include "core/datasets/image_list.h"
#include "core/files/shared_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaxDepthPairing_ns = 20'000'000;
constexpr double kDepthUnitsPerM = 5000.0;

// Calibration of the colour cameras from TUM's "file formats" page; 640 x 480 pixels. Depth maps are registered to the
// colour images. Images of freiburg3 are undistorted.
struct KnownCamera {
  std::string_view long_name;
  std::string_view short_name;
  double fx_px, fy_px, cx_px, cy_px;
  std::array<double, 5> distortion;
};
constexpr std::array<KnownCamera, 3> kKnownCameras = {
    {{"freiburg1", "fr1", 517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
     {"freiburg2", "fr2", 520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}},
     {"freiburg3", "fr3", 535.4, 539.2, 320.1, 247.6, {0.0, 0.0, 0.0, 0.0, 0.0}}}};
constexpr ImageSize kKnownSize{640, 480};

Shots ReadList(const std::string& folder, const char* name) {
  return ReadShots((fs::path(folder) / name).string(), folder, 9, "time in seconds and file name");
}

std::vector<ImageList::Entry> ReadAssociations(const std::string& folder, const std::string& path) {
  std::vector<ImageList::Entry> entries;
  std::vector<int64_t> times_ns;
  ForEachDatasetRow(path, [&](const TextRow& row) {
    RequireColumns(row, 4, "time and file of the colour image, time and file of the depth map");
    const size_t colour = row.fields[1].starts_with("depth") ? 2 : 0;
    AppendTime(row, colour, 9, &times_ns);
    row.Scaled(2 - colour, 9);
    entries.push_back({times_ns.back(), FileBelow(folder, row, colour + 1), FileBelow(folder, row, 3 - colour), ""});
  });
  if (entries.empty()) throw DatasetError(path + ": lists no pairs");
  CheckUnitOfTime(path, 9, times_ns);
  return entries;
}

void PairByTime(const std::string& folder, ImageList* list) {
  const Shots colour = ReadList(folder, "rgb.txt");
  const Shots depth = ReadList(folder, "depth.txt");
  for (const auto& [c, d] : AssociateTimes(colour.times_ns, depth.times_ns, kMaxDepthPairing_ns)) {
    list->entries.push_back({colour.times_ns[c], colour.files[c], depth.files[d], ""});
  }
  if (list->entries.empty()) {
    throw DatasetError(fmt::format(
        "{}: no depth map within 20 ms of a colour image; the first times are {} s (colour) and {} s (depth)",
        (fs::path(folder) / "depth.txt").string(), SecondsText(colour.times_ns.front()),
        SecondsText(depth.times_ns.front())));
  }
  for (const auto& [what, shots] : {std::pair("colour images", &colour), std::pair("depth maps", &depth)}) {
    NoteUnpaired(shots->files.size() - list->entries.size(), shots->files.size(), what, "within 20 ms", &list->notes);
  }
}

/// Returns a camera by the name of the folder; nullptr if the name is none of TUM's.
const KnownCamera* CameraByName(const std::string& folder) {
  for (const fs::path& path : NamesOfFolder(folder)) {
    const std::string name = path.filename().string();
    for (const KnownCamera& known : kKnownCameras) {
      if (name.find(known.long_name) != std::string::npos) return &known;
      if (name.find(known.short_name) != std::string::npos) return &known;
    }
  }
  return nullptr;
}

RigCalibration KnownRig(const KnownCamera& known, const std::string& folder, const ImageSize& size) {
  if (size != kKnownSize) {
    throw DatasetError(fmt::format(
        "{}: images of {} x {} pixels do not match the calibration of {} ({} x {}); give "
        "a camera.yaml",
        folder, size.width_px, size.height_px, known.long_name, kKnownSize.width_px, kKnownSize.height_px));
  }
  CameraCalibration camera{size.width_px, size.height_px, "radtan", known.fx_px, known.fy_px,
                           known.cx_px,   known.cy_px,    {},       SE3()};
  camera.distortion.assign(known.distortion.begin(), known.distortion.end());
  RigCalibration rig = MakeRgbdRig(camera, kVirtualBaseline_m, kDepthUnitsPerM);
  rig.name = known.long_name;
  return rig;
}

/// Reads its camera.yaml, or the known calibration for a folder of that name, or the settings of another program.
/// `path` receives its source.
RigCalibration ReadRig(const std::string& folder, const ImageSize& size, Notes* notes, std::string* path) {
  *path = (fs::path(folder) / "camera.yaml").string();
  const KnownCamera* known = CameraByName(folder);
  if (!fs::exists(*path) && known != nullptr) return KnownRig(*known, folder, size);
  const std::vector<std::string> paths = CalibrationOf(folder);
  if (paths.empty()) {
    throw DatasetError(folder +
                       ": has no camera.yaml and no RGB-D settings of ORB-SLAM, and its name contains none of "
                       "freiburg1, freiburg2, freiburg3, fr1, fr2, fr3, whose calibrations are known");
  }
  *path = paths.front();
  RigCalibration rig = ReadCalibration(paths, size, notes);
  if (rig.kind != RigCalibration::Kind::kRgbd) {
    throw DatasetError(*path + ": is for a stereo pair, but the folder has depth maps: kind must be rgbd");
  }
  return rig;
}

}  // namespace

std::unique_ptr<Dataset> OpenTumDataset(const std::string& folder) {
  ImageList list;
  list.name = folder;
  const fs::path associations = fs::path(folder) / "associations.txt";
  if (fs::exists(associations)) {
    list.entries = ReadAssociations(folder, associations.string());
  } else {
    PairByTime(folder, &list);
  }
  std::string calibration;
  list.image_size = LearnImageSize(list.entries);
  list.rig = ReadRig(folder, list.image_size, &list.notes, &calibration);
  const fs::path truth = fs::path(folder) / "groundtruth.txt";
  if (fs::exists(truth)) list.ground_truth = FrameTruth(truth.string(), TrajectoryFormat::kTum, &list);
  return MakeImageListDataset(std::move(list), calibration);
}

bool LooksLikeTum(const std::string& folder) {
  const fs::path path(folder);
  return (fs::exists(path / "rgb.txt") && fs::exists(path / "depth.txt")) || fs::exists(path / "associations.txt");
}

}  // namespace plslam
