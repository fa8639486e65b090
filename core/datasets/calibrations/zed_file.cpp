// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>

#include "core/datasets/calibrations/readers.h"
#include "core/errors/error_text.h"
#include "core/files/dataset_error.h"

namespace plslam {
namespace {

struct Resolution {
  const char* name;
  int width_px;
  int height_px;
};
constexpr auto kResolutions = std::to_array<Resolution>({{"2K", 2208, 1242},
                                                         {"FHD", 1920, 1080},
                                                         {"FHD1200", 1920, 1200},
                                                         {"HD", 1280, 720},
                                                         {"SVGA", 960, 600},
                                                         {"VGA", 672, 376},
                                                         {"4K", 3840, 2160},
                                                         {"QHDPLUS", 3200, 1800}});
constexpr double kMetresPerMm = 1e-3;
constexpr int kMaxLines = 2000;

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string Trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// `[SECTION]` and `key=value` lines; names are compared without regard to case.
class Sections {
 public:
  explicit Sections(const std::string& path) : path_(path) {
    std::ifstream file(path);
    std::string line, section;
    for (int n = 1; std::getline(file, line); ++n) {
      if (n > kMaxLines || line.size() > 1000) throw DatasetError(path + ": is too long for a ZED calibration");
      line = Trimmed(line);
      if (line.starts_with('[') && line.ends_with(']')) section = Upper(line.substr(1, line.size() - 2));
      const size_t equals = line.find('=');
      if (equals == std::string::npos || line.starts_with('#') || line.starts_with(';')) continue;
      values_[section + ":" + Upper(Trimmed(line.substr(0, equals)))] = {n, Trimmed(line.substr(equals + 1))};
    }
  }

  bool HasSection(const std::string& section) const {
    const auto first = values_.lower_bound(Upper(section) + ":");
    return first != values_.end() && first->first.starts_with(Upper(section) + ":");
  }

  bool Has(const std::string& section, const std::string& key) const {
    return values_.contains(Upper(section + ":" + key));
  }

  double Number(const std::string& section, const std::string& key) const {
    const auto found = values_.find(Upper(section + ":" + key));
    if (found == values_.end()) throw DatasetError(fmt::format("{}: {} of [{}] is missing", path_, key, section));
    const auto& [line, text] = found->second;
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      throw DatasetError(fmt::format("{}:{}: {} = '{}' is not a finite number", path_, line, key, Shown(text)));
    }
    return value;
  }

  double NumberOr(const std::string& section, const std::string& key, double fallback) const {
    return Has(section, key) ? Number(section, key) : fallback;
  }

 private:
  struct Value {
    int line;
    std::string text;
  };
  std::string path_;
  std::map<std::string, Value> values_;
};

const Resolution& ResolutionOf(const std::string& path, const ImageSize& size) {
  std::string known;
  for (const Resolution& resolution : kResolutions) {
    if (resolution.width_px == size.width_px && resolution.height_px == size.height_px) return resolution;
    known += fmt::format("{}{}x{}", known.empty() ? "" : ", ", resolution.width_px, resolution.height_px);
  }
  const std::string given = size.width_px == 0
                                ? "the size of the images is unknown"
                                : fmt::format("the images have {} x {} pixels", size.width_px, size.height_px);
  throw DatasetError(fmt::format("{}: {}, but a ZED has one of {} (--size)", path, given, known));
}

/// One camera, of `side` LEFT or RIGHT. Files of later cameras have the distortion of all resolutions in a separate
/// section.
CameraCalibration ZedCamera(const Sections& file, const std::string& side, const Resolution& resolution) {
  const std::string section = fmt::format("{}_CAM_{}", side, resolution.name), shared = side + "_DISTO";
  CameraCalibration camera;
  camera.width_px = resolution.width_px;
  camera.height_px = resolution.height_px;
  camera.fx_px = file.Number(section, "fx");
  camera.fy_px = file.Number(section, "fy");
  camera.cx_px = file.Number(section, "cx");
  camera.cy_px = file.Number(section, "cy");
  const std::string distortion = !file.Has(section, "k1") && file.Has(shared, "k1") ? shared : section;
  camera.model = lens_model::kRadtan;
  camera.distortion = {file.Number(distortion, "k1"), file.Number(distortion, "k2")};
  for (const char* key : {"p1", "p2", "k3"}) camera.distortion.push_back(file.NumberOr(distortion, key, 0.0));
  std::vector<double> divisor;
  for (const char* key : {"k4", "k5", "k6"}) divisor.push_back(file.NumberOr(distortion, key, 0.0));
  if (std::any_of(divisor.begin(), divisor.end(), [](double k) { return k != 0.0; })) {
    camera.model = lens_model::kRational;
    camera.distortion.insert(camera.distortion.end(), divisor.begin(), divisor.end());
  }
  return camera;
}

/// Returns TY or TZ: of the resolution, or, in the oldest files, of all. They are fractions of a millimetre, and some
/// files omit them; a file that has them only for other resolutions is an error.
double Shift_mm(const Sections& file, const std::string& key, const std::string& resolution) {
  const std::string own = key + "_" + resolution;
  if (file.Has("STEREO", own)) return file.Number("STEREO", own);
  if (file.Has("STEREO", key)) return file.Number("STEREO", key);
  for (const Resolution& other : kResolutions) {
    if (file.Has("STEREO", fmt::format("{}_{}", key, other.name))) return file.Number("STEREO", own);  // fails
  }
  return 0.0;
}

}  // namespace

ForeignCalibration ReadZed(const std::string& path, const ImageSize& image_size) {
  const Sections file(path);
  const Resolution& resolution = ResolutionOf(path, image_size);
  const std::string name = resolution.name;
  if (!file.HasSection("LEFT_CAM_" + name)) {
    throw DatasetError(fmt::format("{}: has no section [LEFT_CAM_{}] for images of {} x {} pixels", path, name,
                                   resolution.width_px, resolution.height_px));
  }
  const CameraCalibration left = ZedCamera(file, "LEFT", resolution);
  const CameraCalibration right = ZedCamera(file, "RIGHT", resolution);
  // The manufacturer's own code gives these to OpenCV's stereoRectify as R and T, with a T.x above 0. Rectification
  // does not change with the sign of T; for the right camera to be on the right it is the other one.
  const double x_mm = file.Number("STEREO", "Baseline");
  // In this order, in which a file that has none of them names the first.
  const double rx = file.Number("STEREO", "RX_" + name), cv = file.Number("STEREO", "CV_" + name),
               rz = file.Number("STEREO", "RZ_" + name);
  const double y_mm = Shift_mm(file, "TY", name), z_mm = Shift_mm(file, "TZ", name);
  const Eigen::Vector3d t_mm(x_mm, y_mm, z_mm), turn(rx, cv, rz);
  const SE3 T_right_left(ExpSO3(turn), -kMetresPerMm * t_mm);
  ForeignCalibration result;
  result.has_own_unit = true;
  result.rig = RigOf(left, right, T_right_left.Inverse());
  result.direction =
      "RX, CV, RZ and -(Baseline, TY, TZ), in millimetres, transform points from the left camera to the right one: "
      "inverted";
  return result;
}

}  // namespace plslam
