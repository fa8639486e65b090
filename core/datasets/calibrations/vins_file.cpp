// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "core/datasets/calibrations/readers.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

/// The lens of a camera in the form of camodocal.
CameraCalibration CamodocalLens(const YamlMap& file) {
  const std::string type = file.Text("model_type");
  const YamlMap projection = file.Map("projection_parameters");
  CameraCalibration camera;
  camera.width_px = PixelsOf(file, "image_width");
  camera.height_px = PixelsOf(file, "image_height");
  if (type == "PINHOLE" || type == "PINHOLE_FULL") {
    SetFocalAndCentre(projection, "", &camera);
    std::vector<double> distortion;
    const YamlMap parameters = file.Map("distortion_parameters");
    for (const char* key : {"k1", "k2", "p1", "p2"}) distortion.push_back(parameters.Number(key));
    if (type == "PINHOLE_FULL") {
      for (const char* key : {"k3", "k4", "k5", "k6"}) distortion.push_back(parameters.Number(key));
    }
    const std::string complaint = SetOpenCvDistortion(distortion, &camera);
    if (!complaint.empty()) file.Fail("distortion_parameters", complaint);
    return camera;
  }
  if (type == "KANNALA_BRANDT") {
    camera.model = lens_model::kEquidistant;
    for (const char* key : {"k2", "k3", "k4", "k5"}) camera.distortion.push_back(projection.Number(key));
    camera.fx_px = projection.Number("mu");
    camera.fy_px = projection.Number("mv");
    camera.cx_px = projection.Number("u0");
    camera.cy_px = projection.Number("v0");
    return camera;
  }
  file.Fail("model_type", fmt::format("'{}' is not supported: calibrate with PINHOLE or KANNALA_BRANDT", type));
}

/// Reads a camera, whose file is in the folder of the settings, or below.
CameraCalibration VinsCamera(const YamlMap& file, const char* calibration, const char* pose) {
  const fs::path name(file.WholeTexts(calibration).front());
  const bool climbs = std::any_of(name.begin(), name.end(), [](const auto& part) { return part == ".."; });
  if (name.empty() || name.is_absolute() || climbs) {
    file.Fail(calibration, fmt::format("= '{}' is empty or leaves the folder of the file: put it into that folder",
                                       file.Text(calibration)));
  }
  CameraCalibration camera = CamodocalLens(YamlMap::FromFile((fs::path(file.path()).parent_path() / name).string()));
  camera.T_b_cam = file.Transform(pose);
  return camera;
}

}  // namespace

ForeignCalibration ReadVins(const YamlMap& file) {
  if (file.Has("num_of_cam") && file.Number("num_of_cam") != 2.0) {
    file.Fail("num_of_cam", fmt::format("= {}: settings of a stereo pair are needed", file.Number("num_of_cam")));
  }
  ForeignCalibration result;
  result.rig.left = VinsCamera(file, "cam0_calib", "body_T_cam0");
  result.rig.right = VinsCamera(file, "cam1_calib", "body_T_cam1");
  result.direction = "body_T_cam0 and body_T_cam1 transform points from each camera to the body: used unchanged";
  return result;
}

}  // namespace plslam
