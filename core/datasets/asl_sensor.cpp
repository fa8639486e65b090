// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/asl_sensor.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/datasets/check_rig.h"
#include "core/datasets/yaml_map.h"

namespace plslam {
namespace {

// Name in the file, and ours.
constexpr std::array<std::pair<const char*, const char*>, 6> kModels = {{{"radial-tangential", "radtan"},
                                                                         {"radtan", "radtan"},
                                                                         {"plumb_bob", "radtan"},
                                                                         {"equidistant", "equidistant"},
                                                                         {"none", "pinhole"},
                                                                         {"None", "pinhole"}}};
// Kalibr's `camera_model` of the double sphere, whose two parameters stand before the focal lengths.
constexpr const char* kDoubleSphere = "ds";

int ToPixels(const YamlMap& yaml, double value) {
  if (!IsImageSide(value)) {
    yaml.Fail("resolution", fmt::format("{} is not a whole number from 1 to {}", value, kMaxImageSide_px));
  }
  return static_cast<int>(value);
}

std::string Model(const YamlMap& yaml) {
  const std::string name = yaml.Text("distortion_model");
  for (const auto& [theirs, ours] : kModels) {
    if (name == theirs) return ours;
  }
  yaml.Fail("distortion_model", fmt::format("'{}' is none of radial-tangential, equidistant, none", name));
}

/// All but where it stands.
CameraCalibration ReadLens(const YamlMap& yaml, const char* distortion) {
  const std::string projection = yaml.Has("camera_model") ? yaml.Text("camera_model") : "pinhole";
  if (projection != "pinhole" && projection != kDoubleSphere) {
    yaml.Fail("camera_model", fmt::format("'{}' is not pinhole, nor {} (double sphere)", projection, kDoubleSphere));
  }
  CameraCalibration camera;
  const std::vector<double> size = yaml.Numbers("resolution", 2, 2);
  camera.width_px = ToPixels(yaml, size[0]);
  camera.height_px = ToPixels(yaml, size[1]);
  const bool is_sphere = projection == kDoubleSphere;
  std::vector<double> intrinsics = is_sphere ? yaml.Numbers("intrinsics", 6, 6) : yaml.Numbers("intrinsics", 4, 4);
  if (is_sphere) {
    camera.distortion.assign(intrinsics.begin(), intrinsics.begin() + 2);
    intrinsics.erase(intrinsics.begin(), intrinsics.begin() + 2);
  }
  camera.fx_px = intrinsics[0];
  camera.fy_px = intrinsics[1];
  camera.cx_px = intrinsics[2];
  camera.cy_px = intrinsics[3];
  camera.model = is_sphere ? "double_sphere" : Model(yaml);
  if (!is_sphere && camera.model != "pinhole") camera.distortion = yaml.Numbers(distortion, 4, 5);
  yaml.Require("resolution", SizeComplaint(camera));
  yaml.Require("intrinsics", FocalComplaint(camera));
  yaml.Require("intrinsics", CentreComplaint(camera));
  if (camera.model != "pinhole") yaml.Require(is_sphere ? "intrinsics" : distortion, DistortionComplaint(camera));
  return camera;
}

}  // namespace

CameraCalibration ReadAslCamera(const std::string& path) {
  const YamlMap yaml = YamlMap::FromFile(path);
  const SE3 T_b_cam = yaml.Transform("T_BS");
  CameraCalibration camera = ReadLens(yaml, "distortion_coefficients");
  camera.T_b_cam = T_b_cam;
  return camera;
}

std::pair<CameraCalibration, CameraCalibration> ReadCamchain(const std::string& path) {
  const YamlMap yaml = YamlMap::FromFile(path);
  const YamlMap cam0 = yaml.Map("cam0"), cam1 = yaml.Map("cam1");
  CameraCalibration left = ReadLens(cam0, "distortion_coeffs"), right = ReadLens(cam1, "distortion_coeffs");
  // Without an IMU the body is the left camera.
  const bool has_imu = cam0.Has("T_cam_imu") || cam1.Has("T_cam_imu");
  const SE3 T_0_b = has_imu ? cam0.Transform("T_cam_imu") : SE3();
  const bool by_chain = !has_imu || (!cam1.Has("T_cam_imu") && cam1.Has("T_cn_cnm1"));
  left.T_b_cam = T_0_b.Inverse();
  right.T_b_cam = (by_chain ? cam1.Transform("T_cn_cnm1") * T_0_b : cam1.Transform("T_cam_imu")).Inverse();
  return {left, right};
}

}  // namespace plslam
