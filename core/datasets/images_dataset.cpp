// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/images_dataset.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/dataset_rows.h"
#include "core/datasets/image_list.h"
#include "core/datasets/imu_files.h"
#include "core/io/images/image_folder.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

struct FolderNames {
  const char* left;
  const char* right;
};
constexpr std::array<FolderNames, 6> kFolderNames = {{{"left", "right"},
                                                      {"image_left", "image_right"},
                                                      {"image_0", "image_1"},
                                                      {"cam0", "cam1"},
                                                      {"cam0/data", "cam1/data"},
                                                      {"rgb", "depth"}}};

std::pair<fs::path, fs::path> FindFolders(const fs::path& folder) {
  std::string known, half;
  for (const FolderNames& names : kFolderNames) {
    // cam0 with a data folder in it holds no images itself.
    const bool nested = fs::is_directory(folder / names.left / "data");
    if (!nested && fs::is_directory(folder / names.left) && fs::is_directory(folder / names.right)) {
      return {folder / names.left, folder / names.right};
    }
    known += fmt::format("{}{} and {}", known.empty() ? "" : ", ", names.left, names.right);
    if (nested || !half.empty()) continue;
    const bool has_left = fs::is_directory(folder / names.left);
    if (!has_left && !fs::is_directory(folder / names.right)) continue;
    half = fmt::format("; it has {} without {}", has_left ? names.left : names.right,
                       has_left ? names.right : names.left);
  }
  throw DatasetError(fmt::format("{}: has none of the pairs of image folders {}{}", folder.string(), known, half));
}

std::vector<ImageList::Entry> Pair(const fs::path& left_folder, const fs::path& right_folder) {
  std::map<ImageKey, ImageList::Entry> pairs;
  for (const auto& [key, path] : ListImages(left_folder.string())) pairs[key].left = path;
  for (const auto& [key, path] : ListImages(right_folder.string())) pairs[key].right = path;
  std::vector<ImageList::Entry> entries;
  for (auto& [key, entry] : pairs) {
    if (entry.left.empty())
      entry.missing = fmt::format("{}: has no partner in {}", entry.right, left_folder.string());
    if (entry.right.empty())
      entry.missing = fmt::format("{}: has no partner in {}", entry.left, right_folder.string());
    entries.push_back(std::move(entry));
  }
  return entries;
}

std::vector<int64_t> Times(const fs::path& folder, const std::string& camera_path, size_t n, double rate_hz) {
  const std::string path = (folder / "times.txt").string();
  if (fs::exists(path)) {
    std::vector<int64_t> times_ns = ReadTimes(path);
    if (times_ns.size() == n) return times_ns;
    throw DatasetError(fmt::format("{}: has {} times for {} frames", path, times_ns.size(), n));
  }
  if (!(rate_hz > 0.0)) throw DatasetError(camera_path + ": rate_hz is missing, and there is no times.txt");
  std::vector<int64_t> times_ns(n);
  for (size_t i = 0; i < n; ++i) times_ns[i] = std::llround(static_cast<double>(i) * 1e9 / rate_hz);
  return times_ns;
}

std::vector<std::optional<SE3>> GroundTruth(const fs::path& folder, ImageList* list) {
  const fs::path timed = folder / "groundtruth.txt", untimed = folder / "poses.txt";
  if (fs::exists(timed)) return FrameTruth(timed.string(), TrajectoryFormat::kTum, list);
  if (fs::exists(untimed)) return TruthOfEachFrame(untimed.string(), list->entries.size(), &list->notes);
  return {};
}

}  // namespace

std::unique_ptr<Dataset> OpenImagesDataset(const std::string& folder) {
  const std::vector<std::string> calibration = CalibrationOf(folder);
  if (calibration.empty()) {
    const std::string unread = UnreadCalibration(folder);
    throw DatasetError((fs::path(folder) / "camera.yaml").string() + ": the calibration is missing" +
                       (unread.empty() ? "" : "; " + unread));
  }
  const std::string& camera_path = calibration.front();
  const auto [left, right] = FindFolders(folder);
  ImageList list;
  list.name = folder;
  list.entries = Pair(left, right);
  list.image_size = LearnImageSize(list.entries);
  list.rig = ReadCalibration(calibration, list.image_size, &list.notes);
  const bool has_depth = left.filename() == "rgb" && right.filename() == "depth";
  if (list.rig.kind == RigCalibration::Kind::kRgbd && !has_depth && !ForeignFormat(camera_path).empty()) {
    throw DatasetError(fmt::format("{}: is for an RGB-D camera, but {} and {} are the images of a stereo pair",
                                   camera_path, left.string(), right.string()));
  }
  const std::vector<int64_t> times_ns = Times(folder, camera_path, list.entries.size(), list.rig.rate_hz);
  for (size_t i = 0; i < times_ns.size(); ++i) list.entries[i].t_ns = times_ns[i];
  list.ground_truth = GroundTruth(folder, &list);
  const std::string own = (fs::path(folder) / "imu.yaml").string();
  AddImu((fs::path(folder) / "imu.csv").string(), own, {.files = {camera_path, own}, .has_camera_file = true}, &list);
  return MakeImageListDataset(std::move(list), camera_path);
}

bool LooksLikeImages(const std::string& folder) { return fs::is_directory(folder) && !CalibrationOf(folder).empty(); }

}  // namespace plslam
