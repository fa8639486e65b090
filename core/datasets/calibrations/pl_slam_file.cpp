// SPDX-License-Identifier: BSD-3-Clause
// Settings of programs that track points and lines: PL-SLAM (the paper's) and AirSLAM.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "core/datasets/calibrations/readers.h"

namespace plslam {
namespace {

constexpr const char* kRotationsIntoRectified = "transform points from each camera to its rectified frame";

CameraCalibration PlSlamLens(const YamlMap& file, const char* matrix, const char* distortion) {
  const std::vector<double> K = file.Numbers(matrix, 4, 4);
  CameraCalibration camera;
  camera.fx_px = K[0];
  camera.fy_px = K[1];
  camera.cx_px = K[2];
  camera.cy_px = K[3];
  if (file.Has(distortion)) SetOpenCvDistortion(file, distortion, &camera);
  return camera;
}

/// R and t of a calibration; its cam_bl was typed by hand, and may be another.
void ReadTransform(const YamlMap& file, const YamlMap& cam0, const CameraCalibration& left,
                   const CameraCalibration& right, ForeignCalibration* result) {
  const std::vector<double> t = cam0.Numbers("t", 3, 3);
  const SE3 T_right_left(RotationOf(cam0, "R"), Eigen::Vector3d(t[0], t[1], t[2]));
  result->rig = RigOf(left, right, T_right_left.Inverse());
  result->direction = "R and t transform points from the left camera to the right one: inverted";
  if (!cam0.Has("cam_bl")) return;
  const double distance_m = T_right_left.translation().norm(), baseline_m = cam0.Number("cam_bl");
  if (std::abs(distance_m - baseline_m) <= 1e-3 * distance_m) return;
  result->notes.Warn(fmt::format("{}: cam_bl = {} is not the length {:.6f} of t, which is used", file.path(),
                                 baseline_m, distance_m));
}

/// One camera matrix: a rectified pair, or two equal lenses that look straight ahead.
void ReadOneLens(const YamlMap& cam0, ForeignCalibration* result) {
  CameraCalibration left;
  SetFocalAndCentre(cam0, "cam_", &left);
  std::vector<double> distortion;
  for (const char* key : {"cam_d0", "cam_d1", "cam_d2", "cam_d3"}) {
    if (cam0.Has(key)) distortion.push_back(cam0.Number(key));
  }
  const std::string complaint = SetOpenCvDistortion(distortion, &left);
  if (!complaint.empty()) cam0.Fail("cam_d0", "and the following: the distortion " + complaint);
  result->rig = RigOf(left, left, AlongX(cam0.Number("cam_bl")));
  result->direction = "both cameras have the same lens and orientation, cam_bl is their baseline";
}

int TypeOf(const YamlMap& file, const char* key, int max) {
  const double type = file.Number(key);
  if (!(type >= 0.0 && type <= max && type == std::floor(type))) {
    file.Fail(key, fmt::format("= {} is not a whole number from 0 to {}", type, max));
  }
  return static_cast<int>(type);
}

/// One of AirSLAM's cameras: fx, fy, cx, cy and five coefficients, of which a fisheye has four.
CameraCalibration AirSlamCamera(const YamlMap& file, const char* name) {
  const YamlMap map = file.Map(name);
  CameraCalibration camera = PlSlamLens(map, "intrinsics", "");
  const int type = TypeOf(file, "distortion_type", 2);
  if (type == 1) SetOpenCvDistortion(map, "distortion_coeffs", &camera);
  if (type == 2) {
    camera.model = lens_model::kEquidistant;
    camera.distortion = map.Numbers("distortion_coeffs", 4, 5);
    camera.distortion.resize(4);
  }
  const SE3 T = map.Transform("T");
  camera.T_b_cam = TypeOf(map, "T_type", 1) == 0 ? T : T.Inverse();
  return camera;
}

/// The first versions had ORB-SLAM2's matrices, without its other keys.
ForeignCalibration ReadEarlyAirSlam(const YamlMap& file) {
  CameraCalibration left, right;
  for (CameraCalibration* camera : {&left, &right}) {
    const std::string side = camera == &left ? "LEFT." : "RIGHT.", matrix = side + "K", distortion = side + "D";
    SetCameraMatrix(file, matrix.c_str(), camera);
    if (file.Has("distortion_type") && TypeOf(file, "distortion_type", 1) == 1) {
      camera->model = lens_model::kEquidistant;
      camera->distortion = file.Matrix(distortion, 4, 5);
      camera->distortion.resize(4);
    } else {
      SetOpenCvDistortion(file, distortion.c_str(), camera);
    }
  }
  const double f_px = file.Matrix("LEFT.P", 12, 12)[0];
  if (!(f_px >= 1.0)) file.Fail("LEFT.P", fmt::format("has the focal length {}, expected 1 pixel or more", f_px));
  const double bf = file.Has("bf") ? file.Number("bf") : -file.Matrix("RIGHT.P", 12, 12)[3];
  ForeignCalibration result;
  result.rig = RigOf(left, right, LeftFromRight(RotationOf(file, "LEFT.R"), RotationOf(file, "RIGHT.R"), bf / f_px));
  result.direction = fmt::format("LEFT.R and RIGHT.R {}", kRotationsIntoRectified);
  return result;
}

}  // namespace

ForeignCalibration ReadPlSlam(const YamlMap& file) {
  const YamlMap cam0 = file.Map("cam0");
  ForeignCalibration result;
  if (cam0.Has("cam_model") && cam0.Text("cam_model") != "Pinhole") {
    cam0.Fail("cam_model", fmt::format("'{}' is not Pinhole", cam0.Text("cam_model")));
  }
  if (!cam0.Has("Kl")) {
    ReadOneLens(cam0, &result);
  } else {
    CameraCalibration left = PlSlamLens(cam0, "Kl", "Dl"), right = PlSlamLens(cam0, "Kr", "Dr");
    if (cam0.Has("R") && cam0.Has("t")) {
      ReadTransform(file, cam0, left, right, &result);
    } else if (cam0.Has("Rl") && cam0.Has("Rr")) {
      const double baseline_m = cam0.Number("cam_bl");
      result.rig = RigOf(left, right, LeftFromRight(RotationOf(cam0, "Rl"), RotationOf(cam0, "Rr"), baseline_m));
      result.direction = fmt::format("Rl and Rr {}, cam_bl is the baseline", kRotationsIntoRectified);
    } else {
      cam0.Fail("R", "or t is missing, and so are Rl and Rr: the rotation between the cameras is unknown");
    }
  }
  SetSize({PixelsOf(cam0, "cam_width"), PixelsOf(cam0, "cam_height")}, &result.rig);
  return result;
}

ForeignCalibration ReadAirSlam(const YamlMap& file, const ImageSize& image_size) {
  ForeignCalibration result;
  if (file.Has("LEFT.K")) {
    result = ReadEarlyAirSlam(file);
  } else {
    result.rig.left = AirSlamCamera(file, "cam0");
    result.rig.right = AirSlamCamera(file, "cam1");
    result.direction = file.Number("cam1.T_type") == 0.0
                           ? "T transforms points from each camera to the body: used unchanged"
                           : "T transforms points from the body to each camera: inverted";
  }
  const bool has_size = file.Has("image_width");
  SetSize(has_size ? ImageSize{PixelsOf(file, "image_width"), PixelsOf(file, "image_height")} : image_size,
          &result.rig);
  return result;
}

}  // namespace plslam
