// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/calibrations/foreign_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>

#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"
#include "core/io/files/dataset_error.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

bool HasOneOf(const YamlMap& file, std::initializer_list<const char*> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return file.Has(key); });
}

bool LooksLikeKalibr(const YamlMap& file) { return file.Has("cam0"); }
bool LooksLikeOpenCv(const YamlMap& file) {
  return HasOneOf(file, {"M1", "K1", "CM1", "cameraMatrix1", "camera_matrix_1"}) ||
         (file.Has("R") && file.Has("T") && !file.Has("P"));
}
bool LooksLikeRos(const YamlMap& file) {
  return file.Has("distortion_model") && HasOneOf(file, {"projection_matrix", "P", "p"});
}
bool LooksLikeOrbSlam(const YamlMap& file) { return HasOneOf(file, {"Camera.fx", "Camera1.fx"}); }
bool LooksLikeStella(const YamlMap& file) { return file.Has("Camera"); }
bool LooksLikeBasalt(const YamlMap& file) { return file.Has("value0"); }

/// A format of one YAML (or JSON) file; the two of several files, and that of ZED, which is no YAML, are read by hand
/// below.
struct Format {
  const char* name;
  bool (*looks_like)(const YamlMap& file);
  ForeignCalibration (*read)(const std::vector<YamlMap>& files, const ImageSize& size);
  size_t max_files;
};
constexpr std::array<Format, 6> kFormats = {
    {{"Kalibr camchain", LooksLikeKalibr,
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadKalibr(files.front()); }, 1},
     {"OpenCV stereo", LooksLikeOpenCv, ReadOpenCv, 2},
     {"ROS camera_info", LooksLikeRos,
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadRos(files); }, 2},
     {"ORB-SLAM", LooksLikeOrbSlam,
      [](const std::vector<YamlMap>& files, const ImageSize& size) { return ReadOrbSlam(files.front(), size); }, 1},
     {"stella_vslam", LooksLikeStella,
      [](const std::vector<YamlMap>& files, const ImageSize& size) { return ReadStella(files.front(), size); }, 1},
     {"Basalt", LooksLikeBasalt,
      [](const std::vector<YamlMap>& files, const ImageSize&) { return ReadBasalt(files.front()); }, 1}}};
constexpr const char* kZed = "ZED";

bool IsZed(const std::string& path) { return fs::path(path).extension() == ".conf"; }

const Format* FormatOf(const YamlMap& file) {
  const auto* found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& f) { return f.looks_like(file); });
  return found == kFormats.end() ? nullptr : found;
}

/// Of a format by its name.
size_t MaxFiles(const std::string& name) {
  const auto* found = std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& f) { return f.name == name; });
  return found == kFormats.end() ? 1 : found->max_files;
}

ForeignCalibration ReadYaml(const std::vector<std::string>& paths, const ImageSize& image_size) {
  std::vector<YamlMap> files;
  files.reserve(paths.size());
  for (const std::string& path : paths) files.push_back(YamlMap::FromFile(path));
  const Format* format = FormatOf(files.front());
  if (format == nullptr) {
    throw DatasetError(
        paths.front() +
        ": is no calibration of a known format (Kalibr camchain, OpenCV M1 D1 M2 D2 R T, ROS camera_info, "
        "ORB-SLAM, stella_vslam, Basalt, ZED)");
  }
  if (files.size() > format->max_files) {
    throw DatasetError(fmt::format("{}: a calibration of the format {} has {} file{}, {} are given", paths.front(),
                                   format->name, format->max_files, format->max_files == 1 ? "" : "s", files.size()));
  }
  ForeignCalibration result = format->read(files, image_size);
  result.format = format->name;
  return result;
}

}  // namespace

std::string ForeignFormat(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return "";
  if (IsZed(path)) return kZed;
  try {
    const Format* format = FormatOf(YamlMap::FromFile(path));
    return format == nullptr ? "" : format->name;
  } catch (const DatasetError&) {
    return "";
  }
}

ForeignCalibration ReadForeignCalibration(const std::vector<std::string>& paths, const ImageSize& image_size) {
  if (paths.empty()) throw DatasetError("no calibration file is given");
  ForeignCalibration result;
  if (IsZed(paths.front())) {
    result = ReadZed(paths.front(), image_size);
    result.format = kZed;
  } else {
    result = ReadYaml(paths, image_size);
  }
  RigCalibration& rig = result.rig;
  if (rig.left.width_px == 0) {
    throw DatasetError(paths.front() + ": does not tell the size of the images; give it (--size WIDTHxHEIGHT)");
  }
  rig.name = fs::path(paths.front()).stem().string();
  rig.baseline_m = (rig.left.T_b_cam.Inverse() * rig.right.T_b_cam).translation().norm();
  const std::string complaint = RigComplaint(rig);
  if (!complaint.empty()) throw DatasetError(fmt::format("{} ({}): {}", paths.front(), result.format, complaint));
  return result;
}

std::vector<std::string> FindForeignCalibration(const std::string& folder) {
  constexpr std::array kExtensions = {".yaml", ".yml", ".json", ".conf"};
  std::map<std::string, std::vector<std::string>> by_format;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string extension = entry.path().extension().string();
    if (std::find(kExtensions.begin(), kExtensions.end(), extension) == kExtensions.end()) continue;
    const std::string format = ForeignFormat(entry.path().string());
    if (!format.empty()) by_format[format].push_back(entry.path().string());
  }
  if (by_format.empty()) return {};
  auto& [format, paths] = *by_format.begin();
  std::sort(paths.begin(), paths.end());
  if (by_format.size() > 1 || paths.size() > MaxFiles(format)) {
    throw DatasetError(
        fmt::format("{}: has several calibrations ({} and {}): name one by `from: FILE` in a camera.yaml", folder,
                    paths.front(), by_format.size() > 1 ? by_format.rbegin()->second.front() : paths.back()));
  }
  return paths;
}

}  // namespace plslam
