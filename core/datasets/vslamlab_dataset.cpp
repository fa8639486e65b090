// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/vslamlab_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/datasets/camera_file.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/dataset_rows.h"
#include "core/datasets/image_list.h"
#include "core/datasets/yaml_map.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLeft = "rgb_0";
constexpr const char* kRight = "rgb_1";
constexpr const char* kDepth = "depth_0";
constexpr double kMaxDepthUnitsPerM = 1e6;

struct Distortion {
  std::string_view theirs;
  const char* ours;
  size_t n;
};
constexpr auto kDistortions = std::to_array<Distortion>(
    {{"radtan4", "radtan", 4}, {"radtan5", "radtan", 5}, {"radtan8", "rational", 8}, {"equid4", "equidistant", 4}});

/// Which columns of rgb.csv are read.
struct Columns {
  size_t time = 0, left = 0, right = 0;
  int decimals = 0;  ///< of times: 0 (nanoseconds) or 9 (seconds)
  bool has_depth = false;
};

std::optional<size_t> Find(const TextRow& names, const std::string& start) {
  const auto at = std::find_if(names.fields.begin(), names.fields.end(),
                               [&](std::string_view name) { return name.starts_with(start); });
  if (at == names.fields.end()) return std::nullopt;
  return static_cast<size_t>(at - names.fields.begin());
}

size_t Require(const TextRow& names, const std::string& start) {
  const std::optional<size_t> column = Find(names, start);
  if (!column) names.Fail(fmt::format("there is no column '{}'", start));
  return *column;
}

Columns ColumnsOf(const TextRow& names) {
  Columns columns;
  columns.time = Require(names, fmt::format("ts_{}", kLeft));
  const bool has_seconds = names.fields[columns.time].ends_with("(s)");
  if (!has_seconds && !names.fields[columns.time].ends_with("(ns)")) {
    names.Fail(fmt::format("the column 'ts_{}' is neither in (ns) nor in (s)", kLeft));
  }
  columns.decimals = has_seconds ? 9 : 0;
  columns.left = Require(names, fmt::format("path_{}", kLeft));
  const std::optional<size_t> right = Find(names, fmt::format("path_{}", kRight));
  const std::optional<size_t> depth = Find(names, fmt::format("path_{}", kDepth));
  if (!right && !depth) {
    names.Fail(
        fmt::format("there is neither a column 'path_{}' nor 'path_{}': a sequence of one camera cannot be played",
                    kRight, kDepth));
  }
  columns.right = right ? *right : *depth;
  columns.has_depth = !right;
  return columns;
}

/// Returns whether the right images are depth maps.
bool ReadTable(const std::string& folder, std::vector<ImageList::Entry>* entries) {
  const std::string path = (fs::path(folder) / "rgb.csv").string();
  std::optional<Columns> columns;
  std::vector<int64_t> times_ns;
  size_t n_columns = 0;
  ForEachDatasetRow(path, [&](const TextRow& row) {
    if (!columns) {
      columns = ColumnsOf(row);
      n_columns = row.fields.size();
      return;
    }
    RequireColumns(row, n_columns, "as many as names in the first line");
    AppendTime(row, columns->time, columns->decimals, &times_ns);
    entries->push_back(
        {times_ns.back(), FileBelow(folder, row, columns->left), FileBelow(folder, row, columns->right), ""});
  });
  if (entries->empty()) throw DatasetError(path + ": lists no images");
  CheckUnitOfTime(path, columns->decimals, times_ns);
  return columns->has_depth;
}

void SetDistortion(const YamlMap& yaml, CameraCalibration* camera) {
  if (!yaml.Has("distortion_type")) return;  // a pinhole
  const std::string type = yaml.Text("distortion_type");
  const auto* const known =
      std::find_if(kDistortions.begin(), kDistortions.end(), [&](const Distortion& d) { return d.theirs == type; });
  if (known == kDistortions.end()) {
    yaml.Fail("distortion_type", fmt::format("'{}' is not one of radtan4, radtan5, radtan8, equid4", type));
  }
  const std::vector<double> values = yaml.Numbers("distortion_coefficients", known->n, known->n);
  if (std::all_of(values.begin(), values.end(), [](double x) { return x == 0.0; })) return;
  camera->model = known->ours;
  camera->distortion = values;
  yaml.Require("distortion_coefficients", DistortionComplaint(*camera));
}

CameraCalibration ReadCamera(const YamlMap& yaml) {
  const std::string model = yaml.Text("cam_model");
  if (model != "pinhole") yaml.Fail("cam_model", fmt::format("'{}' is not pinhole", model));
  CameraCalibration camera;
  const std::vector<double> size = yaml.Numbers("image_dimension", 2, 2);
  for (const double side : size) {
    if (!IsImageSide(side)) {
      yaml.Fail("image_dimension", fmt::format("{} is not a whole number from 1 to {}", side, kMaxImageSide_px));
    }
  }
  camera.width_px = static_cast<int>(size[0]);
  camera.height_px = static_cast<int>(size[1]);
  const std::vector<double> focal = yaml.Numbers("focal_length", 2, 2),
                            centre = yaml.Numbers("principal_point", 2, 2);
  camera.fx_px = focal[0];
  camera.fy_px = focal[1];
  camera.cx_px = centre[0];
  camera.cy_px = centre[1];
  yaml.Require("focal_length", FocalComplaint(camera));
  yaml.Require("principal_point", CentreComplaint(camera));
  SetDistortion(yaml, &camera);
  camera.T_b_cam = yaml.Transform(yaml.Has("T_BS") ? "T_BS" : "T_SC");
  return camera;
}

YamlMap CameraNamed(const YamlMap& file, const std::string& name) {
  std::string others;
  for (const YamlMap& camera : file.Maps("cameras")) {
    const std::string known = camera.Text("cam_name");
    if (known == name) return camera;
    others += (others.empty() ? "" : ", ") + known;
  }
  file.Fail("cameras", fmt::format("has no '{}', but {}", name, others.empty() ? "none" : others));
}

RigCalibration ReadRig(const std::string& path, bool has_depth) {
  const YamlMap file = YamlMap::FromFile(path);
  const YamlMap left = CameraNamed(file, kLeft);
  RigCalibration rig;
  if (has_depth) {
    const double units_per_m = left.Number("depth_factor");
    if (!(units_per_m > 0.0) || units_per_m > kMaxDepthUnitsPerM) {
      left.Fail("depth_factor", fmt::format("{} is not above 0 and at most {:g}", units_per_m, kMaxDepthUnitsPerM));
    }
    rig = MakeRgbdRig(ReadCamera(left), kVirtualBaseline_m, units_per_m);
  } else {
    rig.left = ReadCamera(left);
    rig.right = ReadCamera(CameraNamed(file, kRight));
    rig.baseline_m = (rig.left.T_b_cam.Inverse() * rig.right.T_b_cam).translation().norm();
  }
  rig.name = "vslamlab";
  return rig;
}

}  // namespace

std::unique_ptr<Dataset> OpenVslamLabDataset(const std::string& folder) {
  ImageList list;
  list.name = folder;
  const bool has_depth = ReadTable(folder, &list.entries);
  const std::string calibration = (fs::path(folder) / "calibration.yaml").string();
  list.rig = ReadRig(calibration, has_depth);
  WarnOfLongBaseline(calibration, list.rig, kLengthsAreMetres, &list.notes);
  list.image_size = LearnImageSize(list.entries);
  const fs::path truth = fs::path(folder) / "groundtruth.csv";
  if (fs::exists(truth)) {
    list.ground_truth = FrameTruth(truth.string(), TrajectoryFormat::kVslamLab, &list);
    for (std::optional<SE3>& pose : list.ground_truth) {
      if (pose) pose = *pose * list.rig.left.T_b_cam;
    }
  }
  return MakeImageListDataset(std::move(list), calibration);
}

bool LooksLikeVslamLab(const std::string& folder) {
  const fs::path path(folder);
  return fs::exists(path / "rgb.csv") && fs::exists(path / "calibration.yaml");
}

}  // namespace plslam
