// SPDX-License-Identifier: BSD-3-Clause
#include "camera/rig_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "core/datasets/camera_file.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/yaml_map.h"

namespace plslam::camera {
namespace {

struct Row {
  SourceSpec::Type type;
  const char* key;
  const char* inputs;  ///< as written in the file
  size_t n_inputs;
  bool may_end;
};

constexpr std::array<Row, 6> kRows{{
    {SourceSpec::Type::kSideBySide, "side_by_side", "one device, /dev/video0", 1, false},
    {SourceSpec::Type::kPair, "pair", "two devices, [/dev/video0, /dev/video2]", 2, false},
    {SourceSpec::Type::kGige, "gige", "two names as arv-tool-0.8 lists them, [VENDOR-SERIAL, VENDOR-SERIAL]", 2,
     false},
    {SourceSpec::Type::kFiles, "files", "two files, [left.mp4, right.mp4]", 2, true},
    {SourceSpec::Type::kRtsp, "rtsp", "two addresses, [rtsp://..., rtsp://...]", 2, false},
    {SourceSpec::Type::kPipeline, "pipeline", "one string with two appsinks, named left and right", 1, true},
}};

const Row& RowOf(SourceSpec::Type type) { return *std::ranges::find(kRows, type, &Row::type); }

std::string AllKeys() {
  std::string text;
  for (const Row& row : kRows) text += fmt::format("{}{}", text.empty() ? "" : ", ", row.key);
  return text;
}

const Row& ChosenRow(const YamlMap& yaml) {
  const Row* chosen = nullptr;
  for (const Row& row : kRows) {
    if (!yaml.Has(row.key)) continue;
    if (chosen != nullptr) yaml.Fail(row.key, fmt::format("contradicts {}: give one of the two", chosen->key));
    chosen = &row;
  }
  if (chosen == nullptr) yaml.Fail("source", fmt::format("defines no cameras: give one of {}", AllKeys()));
  return *chosen;
}

double NumberWithin(const YamlMap& yaml, const char* key, double fallback, double min, double max) {
  if (!yaml.Has(key)) return fallback;
  const double value = yaml.Number(key);
  if (!(value >= min && value <= max)) yaml.Fail(key, fmt::format("= {} is not from {} to {}", value, min, max));
  return value;
}

}  // namespace

SourceSpec ReadSource(const YamlMap& yaml) {
  std::vector<std::string> known{"max_skew_ms", "give_up_s"};
  for (const Row& row : kRows) known.emplace_back(row.key);
  yaml.AllowOnly(known);
  const Row& row = ChosenRow(yaml);
  SourceSpec source;
  source.type = row.type;
  source.inputs = yaml.WholeTexts(row.key);
  const bool is_empty = std::ranges::any_of(source.inputs, &std::string::empty);
  if (source.inputs.size() != row.n_inputs || is_empty) {
    yaml.Fail(row.key, fmt::format("has {} entries{}: give {}", source.inputs.size(),
                                   is_empty ? ", one of them empty" : "", row.inputs));
  }
  if (row.n_inputs == 2 && source.inputs[0] == source.inputs[1]) {
    yaml.Fail(row.key, fmt::format("= '{}' is given twice: give {}", source.inputs[0], row.inputs));
  }
  source.max_skew_ms = NumberWithin(yaml, "max_skew_ms", source.max_skew_ms, 0.0, 1000.0);
  source.give_up_s = NumberWithin(yaml, "give_up_s", source.give_up_s, 0.0, 1e6);
  return source;
}

std::string KeyOf(SourceSpec::Type type) { return RowOf(type).key; }

bool MayEnd(SourceSpec::Type type) { return RowOf(type).may_end; }

CameraCalibration ReadUncalibratedCamera(const YamlMap& yaml) {
  if (!yaml.Has("resolution_px")) {
    yaml.Fail("resolution_px", "is missing: the size of the images, [640, 480]");
  }
  const ImageSize size = ReadResolution(yaml, {});
  CameraCalibration camera;
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  camera.fx_px = camera.fy_px = size.width_px;
  camera.cx_px = 0.5 * (size.width_px - 1.0);
  camera.cy_px = 0.5 * (size.height_px - 1.0);
  yaml.Require("resolution_px", SizeComplaint(camera));
  return camera;
}

namespace {

YamlMap ReadWithSource(const std::string& path) {
  YamlMap yaml = YamlMap::FromFile(path);
  if (!yaml.Has("source")) yaml.Fail("source", fmt::format("is missing: a map with one of {}", AllKeys()));
  return yaml;
}

LiveRig WithSource(const YamlMap& yaml, const std::string& path, RigCalibration rig, Notes notes) {
  if (rig.imu) notes.Remark(path + ": imu is not used: live cameras have no samples of an inertial sensor");
  rig.imu.reset();
  LiveRig live{path, std::move(rig), ReadSource(yaml.Map("source")), std::move(notes)};
  const CameraCalibration& left = live.rig.left;
  const CameraCalibration& right = live.rig.right;
  if (live.source.type == SourceSpec::Type::kSideBySide &&
      (left.width_px != right.width_px || left.height_px != right.height_px)) {
    yaml.Map("source").Fail("side_by_side", "needs a left and a right camera of the same resolution_px");
  }
  if (live.source.type == SourceSpec::Type::kFiles) {
    for (std::string& file : live.source.inputs) {
      file = (std::filesystem::path(path).parent_path() / file).string();
    }
  }
  return live;
}

bool HasLens(const YamlMap& camera) {
  return camera.Has("focal_length_px") || camera.Has("principal_point_px") || camera.Has("distortion");
}

CameraCalibration ReadSizeOnly(const YamlMap& camera) {
  camera.AllowOnly({"resolution_px", "model", "T_b_cam", "mask", "mask_polygons", "borders_px"});
  return ReadUncalibratedCamera(camera);
}

}  // namespace

LiveRig ReadRigFile(const std::string& path) {
  const YamlMap yaml = ReadWithSource(path);
  Notes notes;
  RigCalibration rig = ReadCameraFile(path, {}, &notes);
  if (rig.kind != RigCalibration::Kind::kStereo) {
    yaml.Fail("kind", "= rgbd cannot have a source: two cameras are read, left and right");
  }
  return WithSource(yaml, path, std::move(rig), std::move(notes));
}

LiveRig ReadRigFileForPipeline(const std::string& path) {
  const YamlMap yaml = ReadWithSource(path);
  if (yaml.Has("from") || !yaml.Has("left") || HasLens(yaml.Map("left"))) return ReadRigFile(path);
  yaml.AllowOnly({"name", "kind", "rate_hz", "left", "right", "baseline_m", "source"});
  RigCalibration rig;
  rig.left = rig.right = ReadSizeOnly(yaml.Map("left"));
  if (yaml.Has("right") && yaml.Map("right").Has("resolution_px")) rig.right = ReadSizeOnly(yaml.Map("right"));
  rig.rate_hz = ReadRate_hz(yaml, 0.0);
  return WithSource(yaml, path, std::move(rig), {});
}

}  // namespace plslam::camera
