// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/asl_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/datasets/calibrations/readers.h"
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
// Kalibr's `camera_model` of the double sphere, whose two parameters precede the focal lengths.
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
  yaml.Fail("distortion_model", fmt::format("'{}' is not one of radial-tangential, equidistant, none", name));
}

/// Reads a camera without its pose.
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
  camera.model = is_sphere ? lens_model::kDoubleSphere : Model(yaml);
  if (!is_sphere && camera.model != lens_model::kPinhole) camera.distortion = yaml.Numbers(distortion, 4, 5);
  yaml.Require("resolution", SizeComplaint(camera));
  yaml.Require("intrinsics", FocalComplaint(camera));
  yaml.Require("intrinsics", CentreComplaint(camera));
  if (camera.model != lens_model::kPinhole)
    yaml.Require(is_sphere ? "intrinsics" : distortion, DistortionComplaint(camera));
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

namespace {

/// Returns whether two poses differ by more than the rounding of a file.
bool Differ(const SE3& a, const SE3& b) {
  constexpr double kSamePlace_m = 1e-3, kSameDirection_rad = 2e-3;
  const SE3 T_a_b = a.Inverse() * b;
  return T_a_b.translation().norm() > kSamePlace_m || T_a_b.Log().tail<3>().norm() > kSameDirection_rad;
}

/// "x, y, z m, turned by a deg" of a pose.
std::string PoseText(const SE3& T) {
  constexpr double kDegrees = 180.0 / 3.14159265358979323846;
  // Without a sign of zeros.
  const Eigen::Array3d t = (1e4 * T.translation().array()).round() / 1e4 + 0.0;
  return fmt::format("at {:.4f}, {:.4f}, {:.4f} m, turned by {:.2f} deg", t.x(), t.y(), t.z(),
                     kDegrees * T.Log().tail<3>().norm());
}

/// Rejects a camera whose two poses relative to the IMU are not inverse to each other, and warns where T_cn_cnm1 is not
/// that of the poses.
void CheckAgreement(const YamlMap& camera, const std::string& name, const SE3& T_b_cam,
                    const std::optional<SE3>& T_b_before, Notes* notes) {
  if (camera.Has("T_imu_cam") && camera.Has("T_cam_imu")) {
    const SE3 other = camera.Transform("T_cam_imu").Inverse();
    if (Differ(T_b_cam, other)) {
      camera.Fail("T_cam_imu",
                  fmt::format("contradicts T_imu_cam: by T_imu_cam the camera is {} from the IMU, by T_cam_imu {}: "
                              "remove the wrong one",
                              PoseText(T_b_cam), PoseText(other)));
    }
  }
  if (!T_b_before || !camera.Has("T_cn_cnm1")) return;
  const SE3 stated = camera.Transform("T_cn_cnm1").Inverse(), used = T_b_before->Inverse() * T_b_cam;
  if (!Differ(stated, used)) return;
  notes->Warn(fmt::format(
      "{}: T_cn_cnm1 of {} contradicts the poses relative to the IMU, which are used: the camera is {} from "
      "the one before by T_cn_cnm1, and {} by those; remove the wrong one",
      camera.Place("T_cn_cnm1"), name, PoseText(stated), PoseText(used)));
}

/// Returns the time from the first row to the last by `line_delay`, in seconds; 0 without it.
double Readout_ms(const YamlMap& camera, int rows) {
  if (!camera.Has("line_delay")) return 0.0;
  const double line_delay_s = camera.Number("line_delay");
  const double readout_ms = 1e3 * line_delay_s * rows;
  if (!(readout_ms >= 0.0 && readout_ms <= kMaxReadout_ms)) {
    camera.Fail("line_delay", fmt::format("= {} is not within 0 to {} seconds for {} rows: state it in seconds",
                                          line_delay_s, 1e-3 * kMaxReadout_ms / rows, rows));
  }
  return readout_ms;
}

/// Returns body (the IMU, or else the first camera) from camera, by whichever key the file has. `T_b_before` is the
/// pose of the camera before, which T_cn_cnm1 continues.
SE3 PoseInChain(const YamlMap& camera, bool has_imu, const std::optional<SE3>& T_b_before) {
  if (camera.Has("T_imu_cam")) return camera.Transform("T_imu_cam");
  if (camera.Has("T_cam_imu")) return camera.Transform("T_cam_imu").Inverse();
  if (!T_b_before && !has_imu) return {};
  return T_b_before ? *T_b_before * camera.Transform("T_cn_cnm1").Inverse() : camera.Transform("T_cam_imu");
}

/// The cameras of a chain, and the two that are used.
struct Camchain {
  std::vector<NamedCamera> cameras;
  CameraPair pair;
  bool has_imu = false;
  YamlMap left;
};

Camchain ReadChain(const std::string& path, Notes* notes) {
  constexpr int kMaxCameras = 16;
  constexpr double kSameReadout = 0.01;
  const YamlMap yaml = YamlMap::FromFile(path);
  if (yaml.Has("cam0") && !yaml.Has("cam1")) {
    yaml.Fail("cam1", "is missing, so that this is the chain of a single camera: a stereo pair is needed");
  }
  std::vector<std::pair<std::string, YamlMap>> maps;
  for (int i = 0; i < kMaxCameras && (i < 2 || yaml.Has(fmt::format("cam{}", i))); ++i) {
    const std::string name = fmt::format("cam{}", i);
    maps.emplace_back(name, yaml.Map(name));
  }
  const bool has_imu = std::any_of(maps.begin(), maps.end(), [](const auto& camera) {
    return camera.second.Has("T_cam_imu") || camera.second.Has("T_imu_cam");
  });
  std::vector<NamedCamera> cameras;
  std::optional<SE3> T_b_before;
  for (const auto& [name, map] : maps) {
    NamedCamera camera{name, map.Has("rostopic") ? map.Text("rostopic") : "", ReadLens(map, "distortion_coeffs")};
    camera.camera.readout_ms = Readout_ms(map, camera.camera.height_px);
    const SE3 T_b_cam = PoseInChain(map, has_imu, T_b_before);
    CheckAgreement(map, name, T_b_cam, T_b_before, notes);
    T_b_before = camera.camera.T_b_cam = T_b_cam;
    cameras.push_back(std::move(camera));
  }
  const CameraPair pair = ChoosePair(cameras, path);
  const double left_ms = cameras[pair.left].camera.readout_ms, right_ms = cameras[pair.right].camera.readout_ms;
  if (std::abs(left_ms - right_ms) > kSameReadout * left_ms) {
    maps[pair.right].second.Fail(
        "line_delay", fmt::format("is {} ms for all rows, but {} ms in {}: give both cameras the same shutter",
                                  right_ms, left_ms, cameras[pair.left].name));
  }
  if (!pair.note.empty()) notes->Remark(pair.note);
  const YamlMap left = maps[pair.left].second;
  return {std::move(cameras), pair, has_imu, left};
}

}  // namespace

std::pair<CameraCalibration, CameraCalibration> ReadCamchain(const std::string& path, Notes* notes) {
  const Camchain chain = ReadChain(path, notes);
  return {chain.cameras[chain.pair.left].camera, chain.cameras[chain.pair.right].camera};
}

ImuParts ReadCamchainImu(const std::string& path) {
  Notes of_cameras;
  const Camchain chain = ReadChain(path, &of_cameras);
  if (!chain.has_imu) return {};
  ImuParts parts =
      ReadImuKeys(chain.left, {.noise = {"", "", "", ""}, .time = "timeshift_cam_imu", .time_offset_s = -1.0});
  parts.T_b_imu = SE3();
  return parts;
}

}  // namespace plslam
