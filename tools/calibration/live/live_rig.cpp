// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/live/live_rig.h"

#include <yaml-cpp/yaml.h>

#include <filesystem>

#include <fmt/format.h>

#include "camera/rig_file.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/yaml_map.h"

namespace plslam::calibration {
namespace {

std::string SourceText(const camera::SourceSpec& spec, const std::string& path) {
  std::vector<std::string> inputs = spec.inputs;
  if (spec.type == camera::SourceSpec::Type::kFiles) {
    const auto folder = std::filesystem::absolute(path).parent_path();
    for (std::string& input : inputs) input = (folder / input).string();
  }
  YAML::Node root;
  YAML::Node source = root["source"];
  if (inputs.size() == 1) {
    source[camera::KeyOf(spec.type)] = inputs.front();
  } else {
    source[camera::KeyOf(spec.type)] = inputs;
  }
  source["max_skew_ms"] = fmt::format("{}", spec.max_skew_ms);
  source["give_up_s"] = fmt::format("{}", spec.give_up_s);
  return YAML::Dump(root) + "\n";
}

/// Keys that the calibration replaces are accepted; keys that would be missing in the result are not.
void CheckCameraKeys(const YamlMap& camera) {
  for (const char* key : {"mask", "mask_polygons", "borders_px"}) {
    if (camera.Has(key)) camera.Fail(key, "is not copied by a calibration: write it into the result afterwards");
  }
  camera.AllowOnly({"resolution_px", "model", "focal_length_px", "principal_point_px", "distortion", "T_b_cam"});
}

}  // namespace

LiveRigFile ReadLiveRigFile(const std::string& path) {
  const YamlMap yaml = YamlMap::FromFile(path);
  if (!yaml.Has("source")) yaml.Fail("source", "is missing: it states where the images come from");
  if (yaml.Has("from"))
    yaml.Fail("from", "is already a calibration: give the size of the images, left.resolution_px");
  yaml.AllowOnly({"name", "kind", "rate_hz", "left", "right", "baseline_m", "source"});
  if (yaml.Has("kind") && yaml.Text("kind") != "stereo")
    yaml.Fail("kind", "is not stereo: two cameras are calibrated");
  const YamlMap left = yaml.Map("left");
  CheckCameraKeys(left);
  const CameraCalibration made_up = camera::ReadUncalibratedCamera(left);
  LiveRigFile file;
  file.size = {made_up.width_px, made_up.height_px};
  if (yaml.Has("right")) {
    const YamlMap right = yaml.Map("right");
    CheckCameraKeys(right);
    if (right.Has("resolution_px") && !(ReadResolution(right, {}) == file.size)) {
      right.Fail("resolution_px", "differs from that of left: both images must have the same size");
    }
  }
  if (yaml.Has("name")) file.name = yaml.Text("name");
  if (left.Has("T_b_cam")) file.T_b_left = left.Transform("T_b_cam");
  file.rate_hz = ReadRate_hz(yaml, 0.0);
  file.source = SourceText(camera::ReadSource(yaml.Map("source")), path);
  RigCalibration rig;
  rig.name = file.name;
  rig.rate_hz = file.rate_hz;
  rig.left = rig.right = made_up;
  rig.left.T_b_cam = file.T_b_left;
  rig.right.T_b_cam = file.T_b_left * SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  file.for_camera = CameraFileText(rig) + file.source;
  return file;
}

}  // namespace plslam::calibration
