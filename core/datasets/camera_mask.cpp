// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/camera_mask.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "core/geometry/image_mask.h"
#include "core/io/files/dataset_error.h"
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
  // With what is left out already in one image: polygons that are drawn one over the other would open it where the
  // other has holes.
  const cv::Mat before = DrawMask(*camera);
  if (!before.empty()) image.setTo(0, before == 0);
  camera->mask = TraceMask(image);
  const std::string complaint = MaskComplaint(*camera);
  if (!complaint.empty()) throw DatasetError(path + ": " + complaint);
}

}  // namespace plslam
