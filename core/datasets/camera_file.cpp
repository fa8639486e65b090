// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/camera_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/imu_files.h"
#include "core/datasets/yaml_map.h"
#include "core/files/dataset_error.h"
#include "core/geometry/image_mask.h"
#include "core/io/images/image_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

/// In the folder of the calibration or below, as all files of a dataset are.
std::string ImageBeside(const YamlMap& yaml) {
  const fs::path name(yaml.Text("mask"));
  const bool climbs = std::any_of(name.begin(), name.end(), [](const auto& part) { return part == ".."; });
  if (name.empty() || name.is_absolute() || climbs) {
    yaml.Fail("mask", fmt::format("= '{}' is empty or leaves the folder of the file", name.string()));
  }
  return (fs::path(yaml.path()).parent_path() / name).string();
}

void AddPolygons(const YamlMap& yaml, CameraCalibration* camera) {
  for (const std::vector<Eigen::Vector2d>& corners : yaml.Polygons("mask_polygons")) {
    MaskPolygon polygon;
    for (const Eigen::Vector2d& px : corners) polygon.corners_px.emplace_back(px.cast<float>());
    camera->mask.push_back(std::move(polygon));
  }
}

void AddRectangle(double x0, double y0, double x1, double y1, CameraCalibration* camera) {
  if (x1 < x0 || y1 < y0) return;
  const Eigen::Vector2f a = Eigen::Vector2d(x0, y0).cast<float>();
  const Eigen::Vector2f b = Eigen::Vector2d(x1, y1).cast<float>();
  camera->mask.push_back({{a, {b.x(), a.y()}, b, {a.x(), b.y()}}});
}

void AddBorders(const YamlMap& yaml, CameraCalibration* camera) {
  const std::vector<double> borders = yaml.Numbers("borders_px", 4, 4);
  const int most = std::max(camera->width_px, camera->height_px);
  for (const double border : borders) {
    if (border >= 0.0 && border <= most && border == std::floor(border)) continue;
    yaml.Fail("borders_px", fmt::format("= {} is not a whole number from 0 to {}", border, most));
  }
  const double right = camera->width_px - 1.0;
  const double bottom = camera->height_px - 1.0;
  AddRectangle(0.0, 0.0, borders[0] - 1.0, bottom, camera);
  AddRectangle(0.0, 0.0, right, borders[1] - 1.0, camera);
  AddRectangle(right - borders[2] + 1.0, 0.0, right, bottom, camera);
  AddRectangle(0.0, bottom - borders[3] + 1.0, right, bottom, camera);
}

}  // namespace

void ReadMask(const YamlMap& yaml, CameraCalibration* camera) {
  if (yaml.Has("mask")) {
    const std::string path = ImageBeside(yaml);
    try {
      AddMaskImage(path, camera);
    } catch (const DatasetError& error) {
      yaml.Fail("mask", fmt::format("cannot be used: {}", error.what()));
    }
  }
  if (yaml.Has("mask_polygons")) {
    AddPolygons(yaml, camera);
    yaml.Require("mask_polygons", MaskComplaint(*camera));
  }
  if (yaml.Has("borders_px")) {
    AddBorders(yaml, camera);
    yaml.Require("borders_px", MaskComplaint(*camera));
  }
}

void AddMaskImage(const std::string& path, CameraCalibration* camera) {
  cv::Mat image = ReadGreyImage(path, {camera->width_px, camera->height_px});
  // Combined with the previous mask in one image: polygons drawn over each other would open it at the holes of the
  // other.
  const cv::Mat before = DrawMask(*camera);
  if (!before.empty()) image.setTo(0, before == 0);
  camera->mask = TraceMask(image);
  const std::string complaint = MaskComplaint(*camera);
  if (!complaint.empty()) throw DatasetError(path + ": " + complaint);
}

namespace {

namespace fs = std::filesystem;

constexpr double kMaxRate_hz = 100000.0;

double PositiveNumber(const YamlMap& yaml, const char* key, double fallback, double max) {
  if (!yaml.Has(key)) return fallback;
  const double value = yaml.Number(key);
  if (!(value > 0.0 && value <= max)) yaml.Fail(key, fmt::format("= {} is not above 0 and at most {}", value, max));
  return value;
}

}  // namespace

ImageSize ReadResolution(const YamlMap& yaml, const ImageSize& image_size) {
  if (!yaml.Has("resolution_px")) return image_size;
  const std::vector<double> size = yaml.Numbers("resolution_px", 2, 2);
  for (const double value : size) {
    if (!IsImageSide(value)) {
      yaml.Fail("resolution_px", fmt::format("{} is not a whole number from 1 to {}", value, kMaxImageSide_px));
    }
  }
  return {static_cast<int>(size[0]), static_cast<int>(size[1])};
}

double ReadRate_hz(const YamlMap& yaml, double fallback) {
  return PositiveNumber(yaml, "rate_hz", fallback, kMaxRate_hz);
}

namespace {

void ReadReadout(const YamlMap& yaml, CameraCalibration* camera) {
  if (!yaml.Has("readout_ms")) return;
  camera->readout_ms = yaml.Number("readout_ms");
  if (camera->readout_ms >= 0.0 && camera->readout_ms <= kMaxReadout_ms) return;
  yaml.Fail("readout_ms",
            fmt::format("= {} is not within 0 (a global shutter) to {} ms", camera->readout_ms, kMaxReadout_ms));
}

/// Both cameras have one readout, which a frame period contains.
void CheckReadout(const YamlMap& yaml, const RigCalibration& rig) {
  const double readout_ms = rig.left.readout_ms;
  if (rig.right.readout_ms != readout_ms) {
    yaml.Map("right").Fail("readout_ms", fmt::format("= {} differs from {} of the left camera: give both cameras the "
                                                     "same shutter",
                                                     rig.right.readout_ms, readout_ms));
  }
  if (rig.rate_hz > 0.0 && readout_ms > 1000.0 / rig.rate_hz) {
    yaml.Map("left").Fail("readout_ms", fmt::format("= {} is longer than the {} ms between frames of rate_hz = {}",
                                                    readout_ms, 1000.0 / rig.rate_hz, rig.rate_hz));
  }
}

CameraCalibration ReadCamera(const YamlMap& yaml, const ImageSize& image_size) {
  yaml.AllowOnly({"model", "resolution_px", "focal_length_px", "principal_point_px", "distortion", "T_b_cam", "mask",
                  "mask_polygons", "borders_px", "readout_ms"});
  CameraCalibration camera;
  const ImageSize size = ReadResolution(yaml, image_size);
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  if (yaml.Has("model")) camera.model = yaml.Text("model");
  yaml.Require("model", ModelComplaint(camera));
  if (!yaml.Has("focal_length_px") && !yaml.Has("principal_point_px")) {
    yaml.Fail("focal_length_px", "is missing, as the whole lens: `plslam calibrate` measures it");
  }
  const std::vector<double> focal = yaml.Numbers("focal_length_px", 2, 2);
  const std::vector<double> centre = yaml.Numbers("principal_point_px", 2, 2);
  camera.fx_px = focal[0];
  camera.fy_px = focal[1];
  camera.cx_px = centre[0];
  camera.cy_px = centre[1];
  if (yaml.Has("distortion")) camera.distortion = yaml.Numbers("distortion", 0, 8);
  if (yaml.Has("T_b_cam")) camera.T_b_cam = yaml.Transform("T_b_cam");
  yaml.Require("resolution_px", SizeComplaint(camera));
  yaml.Require("focal_length_px", FocalComplaint(camera));
  yaml.Require("principal_point_px", CentreComplaint(camera));
  yaml.Require("distortion", DistortionComplaint(camera));
  ReadMask(yaml, &camera);
  ReadReadout(yaml, &camera);
  return camera;
}

/// Masks belong to one camera each; a right camera without lens keys has the lens of the left one.
CameraCalibration ReadRightLens(const YamlMap& yaml, const CameraCalibration& left) {
  constexpr std::array kLensKeys = {"model", "resolution_px", "focal_length_px", "principal_point_px", "distortion"};
  CameraCalibration camera = left;
  camera.mask.clear();
  if (!yaml.Has("right")) return camera;
  const YamlMap right = yaml.Map("right");
  const bool has_lens =
      std::any_of(kLensKeys.begin(), kLensKeys.end(), [&](const char* key) { return right.Has(key); });
  if (has_lens) {
    camera = ReadCamera(right, {left.width_px, left.height_px});
    if (!right.Has("readout_ms")) camera.readout_ms = left.readout_ms;
    return camera;
  }
  right.AllowOnly({"T_b_cam", "mask", "mask_polygons", "borders_px", "readout_ms"});
  ReadReadout(right, &camera);
  if (right.Has("T_b_cam")) camera.T_b_cam = right.Transform("T_b_cam");
  ReadMask(right, &camera);
  return camera;
}

// A rectified pair is described by one camera and the baseline; any other by two cameras with their poses.
void ReadRightCamera(const YamlMap& yaml, RigCalibration* rig) {
  const bool by_baseline = yaml.Has("baseline_m");
  rig->right = ReadRightLens(yaml, rig->left);
  if (by_baseline && yaml.Has("right") && yaml.Map("right").Has("T_b_cam")) {
    yaml.Fail("baseline_m", "contradicts T_b_cam of the right camera: give one of the two");
  }
  if (by_baseline) {
    rig->right.T_b_cam = rig->left.T_b_cam * AlongX(yaml.Number("baseline_m"));
  } else if (!yaml.Has("right") || !yaml.Map("right").Has("T_b_cam")) {
    yaml.Fail("baseline_m", "is missing, and so is T_b_cam of the right camera");
  }
  rig->baseline_m = (rig->left.T_b_cam.Inverse() * rig->right.T_b_cam).translation().norm();
}

/// Reads files of another program.
RigCalibration ReadForeign(const std::vector<std::string>& paths, const ImageSize& image_size,
                           std::optional<double> metres_per_unit, Notes* notes) {
  const ForeignCalibration calibration = ReadForeignCalibration(paths, image_size, metres_per_unit);
  notes->Add(calibration.notes);
  if (!metres_per_unit) {
    const std::string file = fs::path(paths.front()).filename().string();
    WarnOfLongBaseline(paths.front(), calibration.rig,
                       fmt::format("state the unit of its lengths, m, cm or mm, as `unit: cm` beside `from: {}` in a "
                                   "camera.yaml",
                                   paths.size() == 1 ? file : fmt::format("[{}, ...]", file)),
                       notes);
  }
  return calibration.rig;
}

/// Reads `imu`, beside the sensor of the files that this one names.
std::optional<ImuCalibration> ReadImu(const YamlMap& yaml, const RigCalibration& rig) {
  if (!yaml.Has("imu")) return rig.imu;
  Notes of_use;  // they concern who has samples
  return CompleteImu(ReadImuFile(yaml.path(), OtherKeys::kRefused, &of_use), rig.left.T_b_cam);
}

/// `from: FILE` or `from: [LEFT, RIGHT]`: files of another program beside this one.
RigCalibration ReadFrom(const YamlMap& yaml, const ImageSize& image_size, Notes* notes) {
  yaml.AllowOnly({"from", "unit", "name", "rate_hz", "source", "imu"});
  RigCalibration rig = ReadForeign(FilesNamedBy(yaml), image_size, UnitNamedBy(yaml), notes);
  if (yaml.Has("name")) rig.name = yaml.Text("name");
  rig.rate_hz = ReadRate_hz(yaml, rig.rate_hz);
  rig.imu = ReadImu(yaml, rig);
  return rig;
}

std::string CameraText(const CameraCalibration& camera) {
  std::string text = fmt::format(
      "  model: {}\n  resolution_px: [{}, {}]\n  focal_length_px: [{}, {}]\n  principal_point_px: [{}, {}]\n",
      camera.model, camera.width_px, camera.height_px, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px);
  if (!camera.distortion.empty()) text += fmt::format("  distortion: [{}]\n", fmt::join(camera.distortion, ", "));
  if (camera.readout_ms > 0.0) text += fmt::format("  readout_ms: {}\n", camera.readout_ms);
  const Eigen::Matrix4d T = camera.T_b_cam.matrix();
  text += "  T_b_cam: [";
  for (int i = 0; i < 12; ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : i % 4 == 0 ? ",\n            " : ", ", T(i / 4, i % 4));
  }
  return text + "]\n";
}

}  // namespace

std::vector<std::string> FilesNamedBy(const YamlMap& yaml) {
  std::vector<std::string> paths;
  for (const std::string& name : yaml.Texts("from")) {
    const fs::path file(name);
    const bool climbs = std::any_of(file.begin(), file.end(), [](const auto& part) { return part == ".."; });
    if (file.empty() || file.is_absolute() || climbs) {
      yaml.Fail("from", fmt::format("= '{}' is empty or leaves the folder of the file", name));
    }
    paths.push_back((fs::path(yaml.path()).parent_path() / file).string());
  }
  return paths;
}

std::optional<double> UnitNamedBy(const YamlMap& yaml) {
  if (!yaml.Has("unit")) return std::nullopt;
  const std::optional<double> metres = MetresOf(yaml.Text("unit"));
  if (!metres) yaml.Fail("unit", fmt::format("= '{}' is not one of m, cm, mm", yaml.Text("unit")));
  return metres;
}

bool NamesSource(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  if ((extension != ".yaml" && extension != ".yml") || !fs::is_regular_file(path)) return false;
  try {
    return YamlMap::FromFile(path).Has("source");
  } catch (const DatasetError&) {
    return false;
  }
}

std::vector<std::string> CalibrationOf(const std::string& folder) {
  const std::string own = (fs::path(folder) / "camera.yaml").string();
  if (fs::exists(own)) return {own};
  return FindForeignCalibration(folder);
}

RigCalibration ReadCalibration(const std::vector<std::string>& paths, const ImageSize& image_size, Notes* notes) {
  if (paths.size() == 1) return ReadCameraFile(paths.front(), image_size, notes);
  Notes unread;
  return ReadForeign(paths, image_size, std::nullopt, notes == nullptr ? &unread : notes);
}

std::string CameraFileText(const RigCalibration& rig) {
  std::string text = fmt::format("name: \"{}\"\n", rig.name);
  if (rig.rate_hz > 0.0) text += fmt::format("rate_hz: {}\n", rig.rate_hz);
  if (rig.imu) text += ImuFileText(*rig.imu);
  if (rig.kind == RigCalibration::Kind::kRgbd) {
    return text +
           fmt::format("kind: rgbd\ndepth_units_per_m: {}\nbaseline_m: {}\nleft:\n", rig.depth_units_per_m,
                       rig.baseline_m) +
           CameraText(rig.left);
  }
  return text + "left:\n" + CameraText(rig.left) + "right:\n" + CameraText(rig.right);
}

RigCalibration MakeRgbdRig(const CameraCalibration& camera, double baseline_m, double depth_units_per_m) {
  RigCalibration rig;
  rig.kind = RigCalibration::Kind::kRgbd;
  rig.left = camera;
  rig.right = camera;
  rig.right.T_b_cam = camera.T_b_cam * AlongX(baseline_m);
  rig.baseline_m = baseline_m;
  rig.depth_units_per_m = depth_units_per_m;
  return rig;
}

RigCalibration ReadCameraFile(const std::string& path, const ImageSize& image_size, Notes* notes) {
  Notes unread;
  if (notes == nullptr) notes = &unread;
  if (!ForeignFormat(path).empty()) return ReadForeign({path}, image_size, std::nullopt, notes);
  const YamlMap yaml = YamlMap::FromFile(path);
  if (yaml.Has("from")) return ReadFrom(yaml, image_size, notes);
  yaml.AllowOnly({"name", "kind", "rate_hz", "left", "right", "baseline_m", "depth_units_per_m", "source", "imu"});
  const std::string kind = yaml.Has("kind") ? yaml.Text("kind") : "stereo";
  if (kind != "stereo" && kind != "rgbd") yaml.Fail("kind", fmt::format("'{}' is not one of stereo, rgbd", kind));
  RigCalibration rig;
  // A size that only one camera states is that of both.
  const ImageSize size = yaml.Has("right") ? ReadResolution(yaml.Map("right"), image_size) : image_size;
  rig.left = ReadCamera(yaml.Map("left"), size);
  if (kind == "rgbd") {
    if (yaml.Has("right")) yaml.Fail("right", "is not allowed in a rig of kind rgbd");
    if (!yaml.Has("depth_units_per_m")) yaml.Fail("depth_units_per_m", "is missing");
    rig = MakeRgbdRig(rig.left, PositiveNumber(yaml, "baseline_m", kVirtualBaseline_m, 100.0),
                      PositiveNumber(yaml, "depth_units_per_m", 0.0, 1e6));
  } else {
    ReadRightCamera(yaml, &rig);
    WarnOfLongBaseline(path, rig, kLengthsAreMetres, notes);
  }
  rig.name = yaml.Has("name") ? yaml.Text("name") : "images";
  rig.rate_hz = ReadRate_hz(yaml, 0.0);
  CheckReadout(yaml, rig);
  rig.imu = ReadImu(yaml, rig);
  return rig;
}

}  // namespace plslam
