// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/live/live_rig.h"

#include <yaml-cpp/yaml.h>

#include <filesystem>

#include <fmt/format.h>

#include "core/datasets/camera_file.h"
#include "core/datasets/yaml_map.h"

namespace plslam::calibration {
namespace {

CameraCalibration MadeUpCamera(const ImageSize& size) {
  CameraCalibration camera;
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  camera.fx_px = camera.fy_px = size.width_px;
  camera.cx_px = 0.5 * (size.width_px - 1.0);
  camera.cy_px = 0.5 * (size.height_px - 1.0);
  return camera;
}

std::string SourceText(const std::string& path) {
  YAML::Node root = YAML::LoadFile(path);
  YAML::Node source = root["source"];
  if (source["files"] && source["files"].IsSequence()) {
    const auto folder = std::filesystem::absolute(path).parent_path();
    for (size_t i = 0; i < source["files"].size(); ++i) {
      source["files"][i] = (folder / source["files"][i].as<std::string>()).string();
    }
  }
  YAML::Node only;
  only["source"] = source;
  return YAML::Dump(only) + "\n";
}

}  // namespace

LiveRigFile ReadLiveRigFile(const std::string& path) {
  const YamlMap yaml = YamlMap::FromFile(path);
  if (!yaml.Has("source")) yaml.Fail("source", "is missing: it says where images come from");
  const YamlMap left = yaml.Map("left");
  if (!left.Has("resolution_px")) left.Fail("resolution_px", "is missing: the size of the images, [640, 480]");
  const std::vector<double> size = left.Numbers("resolution_px", 2, 2);
  LiveRigFile file;
  file.rate_hz = yaml.Has("rate_hz") ? yaml.Number("rate_hz") : 0.0;
  file.size = {static_cast<int>(size[0]), static_cast<int>(size[1])};
  file.source = SourceText(path);
  RigCalibration rig;
  rig.name = "not calibrated yet";
  rig.rate_hz = file.rate_hz;
  rig.left = rig.right = MadeUpCamera(file.size);
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  file.for_camera = CameraFileText(rig) + file.source;
  return file;
}

}  // namespace plslam::calibration
