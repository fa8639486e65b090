// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/calibrations/foreign_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>

#include "core/datasets/calibrations/other_settings.h"
#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/imu_files.h"
#include "core/files/dataset_error.h"
#include "core/files/git_lfs.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

/// A format of YAML (or JSON) files; that of ZED, which is no YAML, is read by hand below.
struct Format {
  const char* name;
  bool (*looks_like)(const YamlMap& file);
  ForeignCalibration (*read)(const std::vector<YamlMap>& files, const ImageSize& size);
  size_t max_files;
  ImuParts (*read_imu)(const YamlMap& file, Notes* notes) = nullptr;  ///< of the first file; nullptr: has no sensor
};

/// The first entry of a list of maps has that key.
bool FirstHas(const YamlMap& file, const char* list, const char* key) {
  return file.IsListOfMaps(list) && !file.Maps(list).empty() && file.Maps(list).front().Has(key);
}

// In this order: a file with the keys of two formats is taken for the first.
constexpr std::array<Format, 13> kFormats = {
    {{"PL-SLAM", [](const YamlMap& f) { return f.Has("cam0.Kl") || f.Has("cam0.cam_fx"); },
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadPlSlam(files.front()); }, 1},
     {"AirSLAM", [](const YamlMap& f) { return f.Has("cam0.T_type") || (f.Has("LEFT.K") && !f.Has("Camera.fx")); },
      [](const std::vector<YamlMap>& files, const ImageSize& size) { return ReadAirSlam(files.front(), size); }, 1,
      ReadAirSlamImu},
     {"Kalibr camchain", [](const YamlMap& f) { return f.Has("cam0"); },
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadKalibr(files.front()); }, 1,
      ReadKalibrImu},
     {"VINS-Fusion", [](const YamlMap& f) { return f.Has("cam0_calib"); },
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadVins(files.front()); }, 1, ReadVinsImu},
     {"stella_vslam", [](const YamlMap& f) { return f.Has("Camera.setup"); },
      [](const std::vector<YamlMap>& files, const ImageSize& size) { return ReadStella(files.front(), size); }, 1},
     {"ORB-SLAM", [](const YamlMap& f) { return f.Has("Camera.fx") || f.Has("Camera1.fx"); },
      [](const std::vector<YamlMap>& files, const ImageSize& size) { return ReadOrbSlam(files.front(), size); }, 1,
      ReadOrbSlamImu},
     {"Kimera", [](const YamlMap& f) { return f.Has("T_BS") && f.Has("intrinsics"); },
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadAslPair(files); }, 2, ReadKimeraImu},
     {"ROS camera_info", LooksLikeRos, ReadRos, 2},
     {"OpenCV stereo", LooksLikeOpenCv, ReadOpenCv, 2},
     {"Basalt", [](const YamlMap& f) { return f.Has("value0.T_imu_cam"); },
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadBasalt(files.front()); }, 1,
      ReadBasaltImu},
     {"OKVIS", [](const YamlMap& f) { return FirstHas(f, "cameras", "T_SC") && !FirstHas(f, "cameras", "cam_name"); },
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadOkvis(files.front()); }, 1, ReadOkvisImu},
     {"SVO", [](const YamlMap& f) { return FirstHas(f, "cameras", "camera"); },
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadSvo(files.front()); }, 1, ReadSvoImu},
     {"DepthAI", [](const YamlMap& f) { return f.Has("cameraData"); },
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadDepthAi(files.front()); }, 1}}};
constexpr const char* kZed = "ZED";

bool IsZed(const std::string& path) { return fs::path(path).extension() == ".conf"; }

const Format* FormatOf(const YamlMap& file) {
  const auto* found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& f) { return f.looks_like(file); });
  return found == kFormats.end() ? nullptr : found;
}

/// Returns the largest number of files of the format with this name.
size_t MaxFiles(const std::string& name) {
  const auto* found = std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& f) { return f.name == name; });
  return found == kFormats.end() ? 1 : found->max_files;
}

std::string FormatNames() {
  std::string names;
  for (const Format& format : kFormats) names += std::string(format.name) + ", ";
  return names + kZed;
}

ForeignCalibration ReadYaml(const std::vector<std::string>& paths, const ImageSize& image_size) {
  std::vector<YamlMap> files;
  files.reserve(paths.size());
  for (const std::string& path : paths) {
    const std::string why = WhyOtherText(path);
    if (!why.empty()) throw DatasetError(path + ": " + why);
    files.push_back(YamlMap::FromFile(path));
  }
  const Format* format = FormatOf(files.front());
  if (format == nullptr) {
    const std::string why = WhyOtherSettings(files.front());
    throw DatasetError(fmt::format(
        "{}: {}", paths.front(),
        why.empty() ? fmt::format("is not a calibration of a known format ({}; see docs/datasets.md)", FormatNames())
                    : why));
  }
  if (files.size() > format->max_files) {
    throw DatasetError(fmt::format("{}: a calibration of the format {} has {} file{}, but {} are given",
                                   paths.front(), format->name, format->max_files, format->max_files == 1 ? "" : "s",
                                   files.size()));
  }
  try {
    ForeignCalibration result = format->read(files, image_size);
    result.format = format->name;
    return result;
  } catch (const DatasetError& error) {
    throw DatasetError(fmt::format("{} (read as {})", error.what(), format->name));
  }
}

/// The sensor of a file that is read for its cameras: mistakes in its description do not concern them.
std::optional<ImuCalibration> ImuOrNone(const std::vector<std::string>& paths, const SE3& T_b_left,
                                        std::optional<double> metres_per_unit, Notes* notes) {
  try {
    Notes of_use;  // they concern who has samples
    return CompleteImu(ReadForeignImu(paths, metres_per_unit, &of_use), T_b_left);
  } catch (const DatasetError& error) {
    notes->Warn(fmt::format("the inertial sensor is not used: {}", error.what()));
    return std::nullopt;
  }
}

/// Lengths are in metres from now on.
void Scale(double metres_per_unit, RigCalibration* rig) {
  for (CameraCalibration* camera : {&rig->left, &rig->right}) {
    camera->T_b_cam = SE3(camera->T_b_cam.rotation(), metres_per_unit * camera->T_b_cam.translation());
  }
}

}  // namespace

std::string ForeignFormat(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return "";
  if (IsZed(path)) return kZed;
  try {
    if (!WhyOtherText(path).empty()) return "";
    const Format* format = FormatOf(YamlMap::FromFile(path));
    return format == nullptr ? "" : format->name;
  } catch (const DatasetError&) {
    return "";
  }
}

std::string WhyNoCalibration(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || IsZed(path)) return "";
  try {
    const std::string why = WhyOtherText(path);
    const std::string reason = why.empty() ? WhyOtherSettings(YamlMap::FromFile(path)) : why;
    return reason.empty() ? "" : path + ": " + reason;
  } catch (const DatasetError& unreadable) {
    return unreadable.what();
  }
}

std::optional<double> MetresOf(std::string_view unit) {
  if (unit == "m") return 1.0;
  if (unit == "cm") return 1e-2;
  if (unit == "mm") return 1e-3;
  return std::nullopt;
}

ForeignCalibration ReadForeignCalibration(const std::vector<std::string>& paths, const ImageSize& image_size,
                                          std::optional<double> metres_per_unit) {
  if (paths.empty()) throw DatasetError("no calibration file is given");
  ForeignCalibration result;
  if (IsZed(paths.front())) {
    const std::string why = WhyOtherText(paths.front());
    if (why == kGitLfsPointer) throw DatasetError(paths.front() + ": " + why);
    result = ReadZed(paths.front(), image_size);
    result.format = kZed;
  } else {
    result = ReadYaml(paths, image_size);
  }
  RigCalibration& rig = result.rig;
  if (rig.left.width_px == 0) {
    throw DatasetError(paths.front() + ": does not state the size of the images; give it (--size WIDTHxHEIGHT)");
  }
  if (metres_per_unit && result.has_own_unit) {
    throw DatasetError(
        fmt::format("{}: files of the format {} have a fixed unit: do not give one", paths.front(), result.format));
  }
  if (metres_per_unit) Scale(*metres_per_unit, &rig);
  rig.name = fs::path(paths.front()).stem().string();
  rig.baseline_m = (rig.left.T_b_cam.Inverse() * rig.right.T_b_cam).translation().norm();
  const bool is_stereo = rig.kind == RigCalibration::Kind::kStereo;
  if (is_stereo && !metres_per_unit && !result.has_own_unit && rig.baseline_m > kMaxBaseline_m) {
    throw DatasetError(fmt::format(
        "{} ({}): the cameras stand {:.4g} m apart, more than {} m: state the unit of its lengths, "
        "`plslam calibration --unit mm` (or cm), or `unit: mm` beside `from: {}` in a camera.yaml",
        paths.front(), result.format, rig.baseline_m, kMaxBaseline_m, fs::path(paths.front()).filename().string()));
  }
  const std::string complaint = RigComplaint(rig);
  if (!complaint.empty()) throw DatasetError(fmt::format("{} ({}): {}", paths.front(), result.format, complaint));
  rig.imu = ImuOrNone(paths, rig.left.T_b_cam, metres_per_unit, &result.notes);
  return result;
}

ImuParts ReadForeignImu(const std::vector<std::string>& paths, std::optional<double> metres_per_unit, Notes* notes) {
  if (paths.empty() || IsZed(paths.front())) return {};
  const YamlMap file = YamlMap::FromFile(paths.front());
  const Format* format = FormatOf(file);
  if (format == nullptr || format->read_imu == nullptr) return {};
  ImuParts parts = format->read_imu(file, notes);
  if (metres_per_unit && parts.T_c_imu) {
    parts.T_c_imu = SE3(parts.T_c_imu->rotation(), *metres_per_unit * parts.T_c_imu->translation());
  }
  return parts;
}

namespace {

/// Files right in `folder` with these ends of names, in the order of their names, but for large ones: annotations and
/// results lie beside images, too, and are not read to see that they are no calibrations.
std::vector<std::string> FilesIn(const std::string& folder, std::initializer_list<std::string_view> extensions) {
  constexpr uintmax_t kMostBytesInFolder = 65536;
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string extension = entry.path().extension().string();
    if (std::find(extensions.begin(), extensions.end(), extension) == extensions.end()) continue;
    if (fs::file_size(entry.path(), error) <= kMostBytesInFolder && !error) {
      paths.push_back(entry.path().string());
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace

std::string UnreadCalibration(const std::string& folder) {
  for (const std::string& path : FilesIn(folder, {".yaml", ".yml", ".json", ".xml", ".ini", ".npz", ".npy"})) {
    const std::string why = WhyNoCalibration(path);
    if (!why.empty()) return why;
  }
  return "";
}

std::vector<std::string> FindForeignCalibration(const std::string& folder) {
  std::map<std::string, std::vector<std::string>> by_format;
  for (const std::string& path : FilesIn(folder, {".yaml", ".yml", ".json", ".conf"})) {
    const std::string format = ForeignFormat(path);
    if (!format.empty()) by_format[format].push_back(path);
  }
  if (by_format.empty()) return {};
  const auto& [format, paths] = *by_format.begin();
  if (by_format.size() > 1 || paths.size() > MaxFiles(format)) {
    throw DatasetError(
        fmt::format("{}: has several calibrations ({} and {}): choose one with `from: FILE` in a camera.yaml", folder,
                    paths.front(), by_format.size() > 1 ? by_format.rbegin()->second.front() : paths.back()));
  }
  return paths;
}

}  // namespace plslam
