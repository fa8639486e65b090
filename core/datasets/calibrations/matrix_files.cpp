// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/datasets/asl_sensor.h"
#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"
#include "core/io/files/dataset_error.h"

namespace plslam {
namespace {

/// The names under which one thing is known.
using Names = std::vector<const char*>;

bool HasAny(const YamlMap& file, const Names& names) {
  return std::any_of(names.begin(), names.end(), [&](const char* name) { return file.Has(name); });
}

const char* NameIn(const YamlMap& file, const Names& names) {
  const auto found = std::find_if(names.begin(), names.end(), [&](const char* name) { return file.Has(name); });
  return found == names.end() ? names.front() : *found;
}

/// The file that has it, or the first one, which will then complain.
const YamlMap& FileWith(const std::vector<YamlMap>& files, const Names& names) {
  const auto found = std::find_if(files.begin(), files.end(), [&](const YamlMap& f) { return HasAny(f, names); });
  return found == files.end() ? files.front() : *found;
}

ImageSize OpenCvSize(const std::vector<YamlMap>& files, const ImageSize& image_size) {
  const Names width{"image_width", "width"}, height{"image_height", "height"};
  const Names both{"image_size", "imageSize", "size", "img_size"};
  const YamlMap& file = FileWith(files, both);
  if (HasAny(file, both)) {
    const char* key = NameIn(file, both);
    const std::vector<double> size = file.Matrix(key, 2, 2);
    if (!IsImageSide(size[0]) || !IsImageSide(size[1])) file.Fail(key, "is not a width and a height in pixels");
    return {static_cast<int>(size[0]), static_cast<int>(size[1])};
  }
  const YamlMap& wide = FileWith(files, width);
  if (!HasAny(wide, width)) return image_size;
  return {PixelsOf(wide, NameIn(wide, width)), PixelsOf(wide, NameIn(wide, height))};
}

CameraCalibration OpenCvCamera(const std::vector<YamlMap>& files, const Names& matrix, const Names& distortion,
                               const ImageSize& size) {
  CameraCalibration camera;
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  const YamlMap& with_matrix = FileWith(files, matrix);
  SetCameraMatrix(with_matrix, NameIn(with_matrix, matrix), &camera);
  const YamlMap& with_distortion = FileWith(files, distortion);
  SetOpenCvDistortion(with_distortion, NameIn(with_distortion, distortion), &camera);
  return camera;
}

// ROS 1 writes calibration files with long names and messages with capitals, ROS 2 messages with small letters.
const Names kRosMatrix{"camera_matrix", "K", "k"};
const Names kRosDistortion{"distortion_coefficients", "D", "d"};
const Names kRosRotation{"rectification_matrix", "R", "r"};
const Names kRosProjection{"projection_matrix", "P", "p"};

struct RosCamera {
  CameraCalibration camera;
  Eigen::Matrix3d R_rectified_camera;
  double fx_rectified_px = 0.0;
  /// -fx times the x of this camera in the rectified left one.
  double Tx = 0.0;
};

RosCamera ReadRosCamera(const YamlMap& file) {
  RosCamera ros;
  ros.camera.width_px = PixelsOf(file, NameIn(file, {"image_width", "width"}));
  ros.camera.height_px = PixelsOf(file, NameIn(file, {"image_height", "height"}));
  SetCameraMatrix(file, NameIn(file, kRosMatrix), &ros.camera);
  const std::string model = file.Text("distortion_model");
  const char* distortion = NameIn(file, kRosDistortion);
  if (model == "plumb_bob" || model == "rational_polynomial") {
    SetOpenCvDistortion(file, distortion, &ros.camera);
  } else if (model == "equidistant" || model == "fisheye") {
    ros.camera.model = "equidistant";
    ros.camera.distortion = file.Matrix(distortion, 4, 4);
  } else {
    file.Fail("distortion_model", fmt::format("'{}' is none of plumb_bob, rational_polynomial, equidistant", model));
  }
  ros.R_rectified_camera = RotationOf(file, NameIn(file, kRosRotation));
  const char* projection = NameIn(file, kRosProjection);
  const std::vector<double> P = file.Matrix(projection, 12, 12);
  if (!(P[0] >= 1.0)) file.Fail(projection, fmt::format("has the focal length {}, expected 1 pixel or more", P[0]));
  ros.fx_rectified_px = P[0];
  ros.Tx = P[3];
  return ros;
}

}  // namespace

ForeignCalibration ReadKalibr(const YamlMap& file) {
  const auto [left, right] = ReadCamchain(file.path());
  ForeignCalibration result;
  result.rig.left = left;
  result.rig.right = right;
  const YamlMap cam0 = file.Map("cam0"), cam1 = file.Map("cam1");
  result.direction = cam1.Has("T_cam_imu") ? "T_cam_imu takes points of the IMU to each camera: inverted"
                                           : "T_cn_cnm1 takes points of cam0 to cam1: inverted";
  return result;
}

ForeignCalibration ReadOpenCv(const std::vector<YamlMap>& files, const ImageSize& image_size) {
  const ImageSize size = OpenCvSize(files, image_size);
  const Names rotation{"R"}, translation{"T"};
  const CameraCalibration left = OpenCvCamera(files, {"M1", "K1", "cameraMatrix1", "camera_matrix_1", "CM1"},
                                              {"D1", "distCoeffs1", "dist_coeffs_1"}, size);
  const CameraCalibration right = OpenCvCamera(files, {"M2", "K2", "cameraMatrix2", "camera_matrix_2", "CM2"},
                                               {"D2", "distCoeffs2", "dist_coeffs_2"}, size);
  const std::vector<double> t = FileWith(files, translation).Matrix("T", 3, 3);
  const SE3 T_right_left(RotationOf(FileWith(files, rotation), "R"), Eigen::Vector3d(t[0], t[1], t[2]));
  ForeignCalibration result;
  result.rig = RigOf(left, right, T_right_left.Inverse());
  result.direction = "R and T take points of the left camera to the right one: inverted";
  return result;
}

ForeignCalibration ReadRos(const std::vector<YamlMap>& files) {
  if (files.size() != 2) {
    throw DatasetError(files.front().path() +
                       ": is the camera_info of one camera: give the files of the left and the right one");
  }
  RosCamera left = ReadRosCamera(files[0]), right = ReadRosCamera(files[1]);
  // The order of the files does not matter: only the right camera has an offset.
  const bool exchanged = left.Tx != 0.0 && right.Tx == 0.0;
  if (exchanged) std::swap(left, right);
  const YamlMap& right_file = files[exchanged ? 0 : 1];
  if (right.Tx == 0.0 || left.Tx != 0.0) {
    right_file.Fail(
        NameIn(right_file, kRosProjection),
        "has no offset that tells left from right: the cameras were calibrated one by one, not as a pair");
  }
  const double baseline_m = -right.Tx / right.fx_rectified_px;
  ForeignCalibration result;
  result.rig =
      RigOf(left.camera, right.camera, LeftFromRight(left.R_rectified_camera, right.R_rectified_camera, baseline_m));
  result.direction =
      "the rectification matrices take points of each camera to its rectified frame, and the right "
      "projection's offset is -focal length times baseline";
  return result;
}

}  // namespace plslam
