// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/camera_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/camera_mask.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/yaml_map.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxRate_hz = 100000.0;

ImageSize Resolution(const YamlMap& yaml, const ImageSize& image_size) {
  if (!yaml.Has("resolution_px")) return image_size;
  const std::vector<double> size = yaml.Numbers("resolution_px", 2, 2);
  for (const double value : size) {
    if (!IsImageSide(value)) {
      yaml.Fail("resolution_px", fmt::format("{} is not a whole number from 1 to {}", value, kMaxImageSide_px));
    }
  }
  return {static_cast<int>(size[0]), static_cast<int>(size[1])};
}

CameraCalibration ReadCamera(const YamlMap& yaml, const ImageSize& image_size) {
  yaml.AllowOnly({"model", "resolution_px", "focal_length_px", "principal_point_px", "distortion", "T_b_cam", "mask",
                  "mask_polygons", "borders_px"});
  CameraCalibration camera;
  const ImageSize size = Resolution(yaml, image_size);
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  if (yaml.Has("model")) camera.model = yaml.Text("model");
  yaml.Require("model", ModelComplaint(camera));
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
  return camera;
}

/// Masks are of one camera each; a right camera about which nothing else is said has the lens of the left one.
CameraCalibration ReadRightLens(const YamlMap& yaml, const CameraCalibration& left, const ImageSize& image_size) {
  constexpr std::array kLensKeys = {"model", "resolution_px", "focal_length_px", "principal_point_px", "distortion"};
  CameraCalibration camera = left;
  camera.mask.clear();
  if (!yaml.Has("right")) return camera;
  const YamlMap right = yaml.Map("right");
  const bool has_lens =
      std::any_of(kLensKeys.begin(), kLensKeys.end(), [&](const char* key) { return right.Has(key); });
  if (has_lens) return ReadCamera(right, image_size);
  right.AllowOnly({"T_b_cam", "mask", "mask_polygons", "borders_px"});
  if (right.Has("T_b_cam")) camera.T_b_cam = right.Transform("T_b_cam");
  ReadMask(right, &camera);
  return camera;
}

SE3 AlongX(double x) { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0.0, 0.0)}; }

// A rectified pair is described by one camera and the baseline; any other by two cameras with their poses.
void ReadRightCamera(const YamlMap& yaml, const ImageSize& image_size, RigCalibration* rig) {
  const bool by_baseline = yaml.Has("baseline_m");
  rig->right = ReadRightLens(yaml, rig->left, image_size);
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

double PositiveNumber(const YamlMap& yaml, const char* key, double fallback, double max) {
  if (!yaml.Has(key)) return fallback;
  const double value = yaml.Number(key);
  if (!(value > 0.0 && value <= max)) yaml.Fail(key, fmt::format("= {} is not above 0 and at most {}", value, max));
  return value;
}

/// `from: FILE` or `from: [LEFT, RIGHT]`: files of another program beside this one.
RigCalibration ReadFrom(const YamlMap& yaml, const ImageSize& image_size) {
  yaml.AllowOnly({"from", "name", "rate_hz"});
  std::vector<std::string> paths;
  for (const std::string& name : yaml.Texts("from")) {
    const fs::path file(name);
    const bool climbs = std::any_of(file.begin(), file.end(), [](const auto& part) { return part == ".."; });
    if (file.empty() || file.is_absolute() || climbs) {
      yaml.Fail("from", fmt::format("= '{}' is empty or leaves the folder of the file", name));
    }
    paths.push_back((fs::path(yaml.path()).parent_path() / file).string());
  }
  RigCalibration rig = ReadForeignCalibration(paths, image_size).rig;
  if (yaml.Has("name")) rig.name = yaml.Text("name");
  rig.rate_hz = PositiveNumber(yaml, "rate_hz", rig.rate_hz, kMaxRate_hz);
  return rig;
}

std::string CameraText(const CameraCalibration& camera) {
  std::string text = fmt::format(
      "  model: {}\n  resolution_px: [{}, {}]\n  focal_length_px: [{}, {}]\n  principal_point_px: [{}, {}]\n",
      camera.model, camera.width_px, camera.height_px, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px);
  if (!camera.distortion.empty()) text += fmt::format("  distortion: [{}]\n", fmt::join(camera.distortion, ", "));
  const Eigen::Matrix4d T = camera.T_b_cam.matrix();
  text += "  T_b_cam: [";
  for (int i = 0; i < 12; ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : i % 4 == 0 ? ",\n            " : ", ", T(i / 4, i % 4));
  }
  return text + "]\n";
}

}  // namespace

std::vector<std::string> CalibrationOf(const std::string& folder) {
  const std::string own = (fs::path(folder) / "camera.yaml").string();
  if (fs::exists(own)) return {own};
  return FindForeignCalibration(folder);
}

RigCalibration ReadCalibration(const std::vector<std::string>& paths, const ImageSize& image_size) {
  if (paths.size() == 1) return ReadCameraFile(paths.front(), image_size);
  return ReadForeignCalibration(paths, image_size).rig;
}

std::string CameraFileText(const RigCalibration& rig) {
  std::string text = fmt::format("name: \"{}\"\n", rig.name);
  if (rig.rate_hz > 0.0) text += fmt::format("rate_hz: {}\n", rig.rate_hz);
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

RigCalibration ReadCameraFile(const std::string& path, const ImageSize& image_size) {
  if (!ForeignFormat(path).empty()) return ReadForeignCalibration({path}, image_size).rig;
  const YamlMap yaml = YamlMap::FromFile(path);
  if (yaml.Has("from")) return ReadFrom(yaml, image_size);
  yaml.AllowOnly({"name", "kind", "rate_hz", "left", "right", "baseline_m", "depth_units_per_m"});
  const std::string kind = yaml.Has("kind") ? yaml.Text("kind") : "stereo";
  if (kind != "stereo" && kind != "rgbd") yaml.Fail("kind", fmt::format("'{}' is none of stereo, rgbd", kind));
  RigCalibration rig;
  rig.left = ReadCamera(yaml.Map("left"), image_size);
  if (kind == "rgbd") {
    if (yaml.Has("right")) yaml.Fail("right", "has no place in a rig of kind rgbd");
    if (!yaml.Has("depth_units_per_m")) yaml.Fail("depth_units_per_m", "is missing");
    rig = MakeRgbdRig(rig.left, PositiveNumber(yaml, "baseline_m", kVirtualBaseline_m, 100.0),
                      PositiveNumber(yaml, "depth_units_per_m", 0.0, 1e6));
  } else {
    ReadRightCamera(yaml, image_size, &rig);
  }
  rig.name = yaml.Has("name") ? yaml.Text("name") : "images";
  rig.rate_hz = PositiveNumber(yaml, "rate_hz", 0.0, kMaxRate_hz);
  return rig;
}

}  // namespace plslam
