// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/datasets/asl_sensor.h"
#include "core/datasets/calibrations/camera_info.h"
#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"
#include "core/files/dataset_error.h"

namespace plslam {
namespace {

/// Alternative names of one key.
using Names = std::vector<const char*>;

/// Names in OpenCV's own examples, and in common scripts around it.
struct OpenCvNames {
  Names matrix, distortion;
};
const OpenCvNames kOpenCvLeft{{"M1", "K1", "cameraMatrix1", "camera_matrix_1", "CM1", "cameraMatrixL",
                               "camera_matrix_left", "left_camera_matrix", "K_left"},
                              {"D1", "distCoeffs1", "dist_coeffs_1", "distCoeffL", "distCoeffsL", "dist_coeffs_left",
                               "distortion_coeffs_left", "left_distortion_coefficients", "D_left"}};
const OpenCvNames kOpenCvRight{
    {"M2", "K2", "cameraMatrix2", "camera_matrix_2", "CM2", "cameraMatrixR", "camera_matrix_right",
     "right_camera_matrix", "K_right"},
    {"D2", "distCoeffs2", "dist_coeffs_2", "distCoeffR", "distCoeffsR", "dist_coeffs_right",
     "distortion_coeffs_right", "right_distortion_coefficients", "D_right"}};

// ROS 1 writes calibration files with long names and messages with capitals, ROS 2 messages with small letters.
const Names kRosMatrix{"camera_matrix", "K", "k"};
const Names kRosDistortion{"distortion_coefficients", "D", "d"};
const Names kRosRotation{"rectification_matrix", "R", "r"};
const Names kRosProjection{"projection_matrix", "P", "p"};

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
  const Names width{"image_width", "width", "frame_width"}, height{"image_height", "height", "frame_height"};
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

/// Four coefficients are of OpenCV's `fisheye` module if the files say so, or else k1, k2, p1, p2.
void SetOpenCvLens(const std::vector<YamlMap>& files, const YamlMap& file, const char* key, CameraCalibration* camera,
                   Notes* notes) {
  const Names model{"distortion_model"};
  const YamlMap& with_model = FileWith(files, model);
  const std::string name = HasAny(with_model, model) ? with_model.Text(model.front()) : "";
  if (name == "fisheye" || name == "equidistant") {
    camera->model = lens_model::kEquidistant;
    camera->distortion = file.Matrix(key, 4, 4);
    return;
  }
  SetOpenCvDistortion(file, key, camera);
  if (notes == nullptr || !name.empty() || camera->distortion.size() != 4) return;
  notes->Remark(
      fmt::format("{}: the 4 numbers of {} are read as k1, k2, p1, p2; if cv2.fisheye made them, add a line "
                  "`distortion_model: fisheye`",
                  file.Place(key), key));
}

CameraCalibration OpenCvCamera(const std::vector<YamlMap>& files, const Names& matrix, const Names& distortion,
                               const ImageSize& size, Notes* notes) {
  CameraCalibration camera;
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  const YamlMap& with_matrix = FileWith(files, matrix);
  SetCameraMatrix(with_matrix, NameIn(with_matrix, matrix), &camera);
  const YamlMap& with_distortion = FileWith(files, distortion);
  SetOpenCvLens(files, with_distortion, NameIn(with_distortion, distortion), &camera, notes);
  return camera;
}

}  // namespace

bool LooksLikeOpenCv(const YamlMap& file) {
  return file.Has("K0") || HasAny(file, kOpenCvLeft.matrix) ||
         (file.Has("R") && HasAny(file, {"T", "t"}) && !file.Has("P"));
}

bool LooksLikeRos(const YamlMap& file) { return HasAny(file, kRosMatrix) && HasAny(file, kRosProjection); }

namespace {

int PixelsOr(const YamlMap& yaml, const char* key, int fallback) {
  if (!yaml.Has(key)) return fallback;
  const double value = yaml.Number(key);
  if (!(value >= 0.0 && value <= kMaxImageSide_px && value == std::floor(value))) {
    yaml.Fail(key, fmt::format("= {} is not a whole number from 0 to {}", value, kMaxImageSide_px));
  }
  return static_cast<int>(value);
}

RosCameraInfo CameraInfoFrom(const YamlMap& file) {
  using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  using Rows34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  RosCameraInfo info;
  info.width_px = PixelsOf(file, NameIn(file, {"image_width", "width"}));
  info.height_px = PixelsOf(file, NameIn(file, {"image_height", "height"}));
  CameraCalibration checked;
  const char* matrix = NameIn(file, kRosMatrix);
  SetCameraMatrix(file, matrix, &checked);
  info.K = Eigen::Map<const Rows3>(file.Matrix(matrix, 9, 9).data());
  // Files of early ROS name no model: it is plumb_bob, as their own reader has it.
  info.model = file.Has("distortion_model") ? file.Text("distortion_model") : "plumb_bob";
  constexpr std::array kModels = {"plumb_bob", "rational_polynomial", "equidistant", "fisheye", ""};
  if (std::find(kModels.begin(), kModels.end(), info.model) == kModels.end()) {
    file.Fail("distortion_model",
              fmt::format("'{}' is not one of plumb_bob, rational_polynomial, equidistant", info.model));
  }
  if (HasAny(file, kRosDistortion)) info.distortion = file.Matrix(NameIn(file, kRosDistortion), 0, 14);
  const char* rotation = NameIn(file, kRosRotation);
  if (HasAny(file, kRosRotation)) info.R = RotationOf(file, rotation);
  const char* projection = NameIn(file, kRosProjection);
  info.P = Eigen::Map<const Rows34>(file.Matrix(projection, 12, 12).data());
  if (info.P.isZero(0.0)) {
    file.Fail(projection, "is all 0: the camera is not calibrated, or not as one of a pair");
  }
  if (!(info.P(0, 0) >= 1.0 && info.P(1, 1) >= 1.0)) {
    file.Fail(projection,
              fmt::format("has the focal lengths {} and {}, expected 1 pixel or more", info.P(0, 0), info.P(1, 1)));
  }
  info.binning_x = PixelsOr(file, "binning_x", 1);
  info.binning_y = PixelsOr(file, "binning_y", 1);
  info.roi = {PixelsOr(file, "roi.x_offset", 0), PixelsOr(file, "roi.y_offset", 0), PixelsOr(file, "roi.width", 0),
              PixelsOr(file, "roi.height", 0)};
  return info;
}

}  // namespace

ForeignCalibration ReadKalibr(const YamlMap& file) {
  ForeignCalibration result;
  const auto [left, right] = ReadCamchain(file.path(), &result.notes);
  result.rig.left = left;
  result.rig.right = right;
  result.direction =
      file.Has("cam1.T_imu_cam")   ? "T_imu_cam transforms points from each camera to the IMU: used unchanged"
      : file.Has("cam1.T_cam_imu") ? "T_cam_imu transforms points from the IMU to each camera: inverted"
                                   : "T_cn_cnm1 transforms points from cam0 to cam1: inverted";
  return result;
}

ForeignCalibration ReadAslPair(const std::vector<YamlMap>& files) {
  if (files.size() != 2) {
    throw DatasetError(files.front().path() +
                       ": is for one camera: give the files of the left and the right one (LeftCameraParams.yaml "
                       "RightCameraParams.yaml)");
  }
  ForeignCalibration result;
  result.rig.left = ReadAslCamera(files[0].path());
  result.rig.right = ReadAslCamera(files[1].path());
  if (files[0].Has("rate_hz")) result.rig.rate_hz = files[0].Number("rate_hz");
  result.direction = "T_BS transforms points from each camera to the body: used unchanged";
  return result;
}

ForeignCalibration ReadOpenCv(const std::vector<YamlMap>& files, const ImageSize& image_size) {
  const ImageSize size = OpenCvSize(files, image_size);
  // Some count their cameras from 0.
  const bool from_0 = HasAny(FileWith(files, {"K0"}), {"K0"});
  ForeignCalibration result;
  const CameraCalibration left = OpenCvCamera(files, from_0 ? Names{"K0"} : kOpenCvLeft.matrix,
                                              from_0 ? Names{"D0"} : kOpenCvLeft.distortion, size, &result.notes);
  const CameraCalibration right = OpenCvCamera(files, from_0 ? Names{"K1"} : kOpenCvRight.matrix,
                                               from_0 ? Names{"D1"} : kOpenCvRight.distortion, size, nullptr);
  const Names rotation{"R"}, translation{"T", "t"};
  const YamlMap& with_translation = FileWith(files, translation);
  const std::vector<double> t = with_translation.Matrix(NameIn(with_translation, translation), 3, 3);
  const SE3 T_right_left(RotationOf(FileWith(files, rotation), "R"), Eigen::Vector3d(t[0], t[1], t[2]));
  result.rig = RigOf(left, right, T_right_left.Inverse());
  result.direction = "R and T transform points from the left camera to the right one: inverted";
  return result;
}

ForeignCalibration ReadRos(const std::vector<YamlMap>& files, const ImageSize& image_size) {
  if (files.size() != 2) {
    throw DatasetError(files.front().path() +
                       ": is the camera_info of one camera: give the files of the left and the right one");
  }
  RosCameraInfo left = CameraInfoFrom(files[0]), right = CameraInfoFrom(files[1]);
  // The order of the files does not matter: only the right camera has an offset.
  const auto has_offset = [](const RosCameraInfo& info) { return !info.P.col(3).isZero(0.0); };
  if (has_offset(left) && !has_offset(right)) std::swap(left, right);
  ForeignCalibration result;
  try {
    result.rig = RigFromRos(InPixelsOfImages(left, image_size), InPixelsOfImages(right, image_size), false);
  } catch (const DatasetError& error) {
    const auto place = [](const YamlMap& file) { return file.Place(NameIn(file, kRosProjection)); };
    throw DatasetError(fmt::format("{} and {}: {}", place(files[0]), place(files[1]), error.what()));
  }
  result.direction =
      "the rectification matrices transform points from each camera to its rectified frame, and the offset of the "
      "right projection is -focal length times baseline";
  return result;
}

}  // namespace plslam
