// SPDX-License-Identifier: BSD-3-Clause
// Files that list their cameras: OKVIS, OKVIS2 and SVO.
#include <fmt/format.h>

#include <array>
#include <utility>

#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"

namespace plslam {
namespace {

/// A distortion by its name in the file; how many coefficients it has there.
struct Distortion {
  const char* theirs;
  const char* ours;
  size_t min_count, max_count;
};
constexpr auto kDistortions = std::to_array<Distortion>({{"radialtangential", "radtan", 4, 5},
                                                         {"radial-tangential", "radtan", 4, 5},
                                                         {"plumb_bob", "radtan", 4, 5},
                                                         {"radialtangential8", "rational", 8, 8},
                                                         {"equidistant", "equidistant", 4, 4},
                                                         {"none", "pinhole", 0, 14},
                                                         {"no-distortion", "pinhole", 0, 14}});

void SetDistortion(const YamlMap& file, const char* type, const char* coefficients, CameraCalibration* camera) {
  const std::string name = file.Text(type);
  for (const Distortion& distortion : kDistortions) {
    if (name != distortion.theirs) continue;
    camera->model = distortion.ours;
    if (camera->model == lens_model::kPinhole) return;
    camera->distortion = file.Matrix(coefficients, distortion.min_count, distortion.max_count);
    file.Require(coefficients, DistortionComplaint(*camera));
    return;
  }
  file.Fail(type, fmt::format("'{}' is not one of radialtangential, radialtangential8, equidistant, none", name));
}

CameraCalibration OkvisCamera(const YamlMap& file) {
  CameraCalibration camera;
  const std::vector<double> size = file.Numbers("image_dimension", 2, 2), focal = file.Numbers("focal_length", 2, 2),
                            centre = file.Numbers("principal_point", 2, 2);
  if (!IsImageSide(size[0]) || !IsImageSide(size[1])) {
    file.Fail("image_dimension", "is not a width and a height in pixels");
  }
  camera.width_px = static_cast<int>(size[0]);
  camera.height_px = static_cast<int>(size[1]);
  camera.fx_px = focal[0];
  camera.fy_px = focal[1];
  camera.cx_px = centre[0];
  camera.cy_px = centre[1];
  SetDistortion(file, "distortion_type", "distortion_coefficients", &camera);
  camera.T_b_cam = file.Transform("T_SC");
  return camera;
}

CameraCalibration SvoCamera(const YamlMap& file) {
  CameraCalibration camera;
  const std::string type = file.Text("camera.type");
  if (type != "pinhole") {
    file.Fail("camera.type", fmt::format("'{}' is not pinhole: calibrate with a pinhole or equidistant lens", type));
  }
  camera.width_px = PixelsOf(file, "camera.image_width");
  camera.height_px = PixelsOf(file, "camera.image_height");
  const std::vector<double> K = file.Matrix("camera.intrinsics", 4, 4);
  camera.fx_px = K[0];
  camera.fy_px = K[1];
  camera.cx_px = K[2];
  camera.cy_px = K[3];
  SetDistortion(file, "camera.distortion.type", "camera.distortion.parameters", &camera);
  camera.T_b_cam = file.Transform("T_B_C");
  return camera;
}

ForeignCalibration PairOf(const YamlMap& file, CameraCalibration (*read)(const YamlMap&)) {
  std::vector<NamedCamera> cameras;
  for (const YamlMap& map : file.Maps("cameras")) {
    cameras.push_back({fmt::format("camera {}", cameras.size()), "", read(map)});
  }
  const CameraPair pair = ChoosePair(cameras, file.Place("cameras"));
  ForeignCalibration result;
  if (!pair.note.empty()) result.notes.Remark(pair.note);
  result.rig.left = cameras[pair.left].camera;
  result.rig.right = cameras[pair.right].camera;
  return result;
}

}  // namespace

ForeignCalibration ReadOkvis(const YamlMap& file) {
  ForeignCalibration result = PairOf(file, OkvisCamera);
  if (file.Has("camera_params.camera_rate")) result.rig.rate_hz = file.Number("camera_params.camera_rate");
  result.direction = "T_SC transforms points from each camera to the IMU: used unchanged";
  return result;
}

ForeignCalibration ReadSvo(const YamlMap& file) {
  ForeignCalibration result = PairOf(file, SvoCamera);
  result.direction = "T_B_C transforms points from each camera to the body: used unchanged";
  return result;
}

}  // namespace plslam
