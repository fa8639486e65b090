// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>

#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"

namespace plslam {
namespace {

std::string In(const std::string& camera, const char* key) { return camera + "." + key; }

/// fx fy cx cy, behind `prefix`.
void SetFocalAndCentre(const YamlMap& file, const std::string& prefix, CameraCalibration* camera) {
  camera->fx_px = file.Number(prefix + "fx");
  camera->fy_px = file.Number(prefix + "fy");
  camera->cx_px = file.Number(prefix + "cx");
  camera->cy_px = file.Number(prefix + "cy");
}

/// Intrinsics and distortion of `Camera1.` and so on, as ORB-SLAM3 has them.
CameraCalibration OrbSlamLens(const YamlMap& file, const std::string& camera, const std::string& type) {
  CameraCalibration lens;
  SetFocalAndCentre(file, In(camera, ""), &lens);
  if (type == "Rectified" || !file.Has(In(camera, "k1"))) return lens;
  if (type == "KannalaBrandt8") {
    lens.model = "equidistant";
    for (const char* key : {"k1", "k2", "k3", "k4"}) lens.distortion.push_back(file.Number(In(camera, key)));
    return lens;
  }
  lens.model = "radtan";
  for (const char* key : {"k1", "k2", "p1", "p2"}) lens.distortion.push_back(file.Number(In(camera, key)));
  if (file.Has(In(camera, "k3"))) lens.distortion.push_back(file.Number(In(camera, "k3")));
  return lens;
}

ImageSize SizeIn(const YamlMap& file, const char* width, const char* height, const ImageSize& image_size) {
  if (!file.Has(width)) return image_size;
  return {PixelsOf(file, width), PixelsOf(file, height)};
}

void SetSize(const ImageSize& size, RigCalibration* rig) {
  for (CameraCalibration* camera : {&rig->left, &rig->right}) {
    camera->width_px = size.width_px;
    camera->height_px = size.height_px;
  }
}

double Quotient(const YamlMap& file, const char* numerator, double denominator) {
  const double value = file.Number(numerator);
  if (!(denominator >= 1.0)) file.Fail(numerator, fmt::format("belongs to a focal length of {} pixels", denominator));
  return value / denominator;
}

/// ORB-SLAM3 with a version: two cameras, or one that is rectified.
ForeignCalibration ReadOrbSlam3(const YamlMap& file, const ImageSize& image_size) {
  const std::string type = file.Text("Camera.type");
  if (type != "PinHole" && type != "KannalaBrandt8" && type != "Rectified") {
    file.Fail("Camera.type", fmt::format("'{}' is none of PinHole, KannalaBrandt8, Rectified", type));
  }
  const CameraCalibration left = OrbSlamLens(file, "Camera1", type);
  ForeignCalibration result;
  if (type == "Rectified") {
    result.rig = RigOf(left, left, AlongX(file.Number("Stereo.b")));
    result.direction = "the pair is rectified, Stereo.b is its baseline";
  } else {
    result.rig = RigOf(left, OrbSlamLens(file, "Camera2", type), file.Transform("Stereo.T_c1_c2"));
    result.direction = "Stereo.T_c1_c2 takes points of the right camera to the left one: used as it is";
  }
  SetSize(SizeIn(file, "Camera.width", "Camera.height", image_size), &result.rig);
  return result;
}

/// Refuses what looks like the settings of a rectified pair and is something else.
void RequireRectified(const YamlMap& file) {
  if (file.Has("DepthMapFactor")) file.Fail("DepthMapFactor", "tells of an RGB-D camera, not of a stereo pair");
  if (file.Has("Tlr")) {
    file.Fail("Tlr",
              "is of an ORB-SLAM3 file of before version 1.0: write it as Stereo.T_c1_c2, with Camera1 and Camera2");
  }
  for (const char* key : {"Camera.k1", "Camera.k2", "Camera.p1", "Camera.p2"}) {
    if (file.Has(key) && file.Number(key) != 0.0) {
      file.Fail(key, fmt::format("= {} is not 0 as in a rectified pair, and LEFT.K, which rectifies, is missing",
                                 file.Number(key)));
    }
  }
}

/// ORB-SLAM2: a rectified camera with its baseline times focal length, and, where the images are not rectified yet,
/// the matrices that rectify them.
ForeignCalibration ReadOrbSlam2(const YamlMap& file, const ImageSize& image_size) {
  const double baseline_m = Quotient(file, "Camera.bf", file.Number("Camera.fx"));
  ForeignCalibration result;
  if (!file.Has("LEFT.K")) {
    RequireRectified(file);
    const CameraCalibration left = OrbSlamLens(file, "Camera", "Rectified");
    result.rig = RigOf(left, left, AlongX(baseline_m));
    SetSize(SizeIn(file, "Camera.width", "Camera.height", image_size), &result.rig);
    result.direction = "the pair is rectified, Camera.bf is baseline times focal length";
    return result;
  }
  CameraCalibration left, right;
  SetCameraMatrix(file, "LEFT.K", &left);
  SetOpenCvDistortion(file, "LEFT.D", &left);
  SetCameraMatrix(file, "RIGHT.K", &right);
  SetOpenCvDistortion(file, "RIGHT.D", &right);
  result.rig = RigOf(left, right, LeftFromRight(RotationOf(file, "LEFT.R"), RotationOf(file, "RIGHT.R"), baseline_m));
  SetSize(SizeIn(file, "LEFT.width", "LEFT.height", image_size), &result.rig);
  result.direction = "LEFT.R and RIGHT.R take points of each camera to its rectified frame";
  return result;
}

/// One of Basalt's cameras, by its kind.
CameraCalibration BasaltCamera(const YamlMap& file) {
  const std::string type = file.Text("camera_type");
  const YamlMap values = file.Map("intrinsics");
  CameraCalibration camera;
  SetFocalAndCentre(values, "", &camera);
  std::vector<const char*> coefficients;
  if (type == "ds") {
    camera.model = "double_sphere";
    coefficients = {"xi", "alpha"};
  } else if (type == "kb4") {
    camera.model = "equidistant";
    coefficients = {"k1", "k2", "k3", "k4"};
  } else if (type == "pinhole-radtan8") {
    camera.model = "rational";
    coefficients = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  } else if (type != "pinhole") {
    file.Fail("camera_type",
              fmt::format("'{}' is none of pinhole, pinhole-radtan8, kb4, ds: calibrate with one of them", type));
  }
  for (const char* key : coefficients) camera.distortion.push_back(values.Number(key));
  file.Require("intrinsics", DistortionComplaint(camera));
  return camera;
}

SE3 BasaltPose(const YamlMap& pose) {
  const Eigen::Quaterniond q(pose.Number("qw"), pose.Number("qx"), pose.Number("qy"), pose.Number("qz"));
  if (!(std::abs(q.norm() - 1.0) < 1e-3)) {
    pose.Fail("qw", fmt::format("belongs to a quaternion of length {:.6g}, expected 1", q.norm()));
  }
  return {q, Eigen::Vector3d(pose.Number("px"), pose.Number("py"), pose.Number("pz"))};
}

}  // namespace

ForeignCalibration ReadOrbSlam(const YamlMap& file, const ImageSize& image_size) {
  ForeignCalibration result =
      file.Has("Camera1.fx") ? ReadOrbSlam3(file, image_size) : ReadOrbSlam2(file, image_size);
  if (file.Has("Camera.fps")) result.rig.rate_hz = file.Number("Camera.fps");
  return result;
}

ForeignCalibration ReadStella(const YamlMap& file, const ImageSize& image_size) {
  const YamlMap camera = file.Map("Camera");
  const std::string setup = camera.Text("setup");
  if (setup != "stereo") camera.Fail("setup", fmt::format("'{}' is not stereo", setup));
  const double baseline_m = Quotient(camera, "focal_x_baseline", camera.Number("fx"));
  ForeignCalibration result;
  CameraCalibration left, right;
  if (!file.Has("StereoRectifier")) {
    SetFocalAndCentre(camera, "", &left);
    result.rig = RigOf(left, left, AlongX(baseline_m));
    result.direction = "the pair is rectified, focal_x_baseline is focal length times baseline";
  } else {
    const YamlMap rectifier = file.Map("StereoRectifier");
    SetCameraMatrix(rectifier, "K_left", &left);
    SetCameraMatrix(rectifier, "K_right", &right);
    const std::string model = rectifier.Has("model") ? rectifier.Text("model") : "perspective";
    if (model == "fisheye") {
      left.model = right.model = "equidistant";
      left.distortion = rectifier.Matrix("D_left", 4, 4);
      right.distortion = rectifier.Matrix("D_right", 4, 4);
    } else if (model == "perspective") {
      SetOpenCvDistortion(rectifier, "D_left", &left);
      SetOpenCvDistortion(rectifier, "D_right", &right);
    } else {
      rectifier.Fail("model", fmt::format("'{}' is none of perspective, fisheye", model));
    }
    result.rig = RigOf(left, right,
                       LeftFromRight(RotationOf(rectifier, "R_left"), RotationOf(rectifier, "R_right"), baseline_m));
    result.direction = "R_left and R_right take points of each camera to its rectified frame";
  }
  SetSize(SizeIn(camera, "cols", "rows", image_size), &result.rig);
  if (camera.Has("fps")) result.rig.rate_hz = camera.Number("fps");
  return result;
}

ForeignCalibration ReadBasalt(const YamlMap& file) {
  const YamlMap value = file.Map("value0");
  const std::vector<YamlMap> poses = value.Maps("T_imu_cam"), lenses = value.Maps("intrinsics");
  if (poses.size() != 2) value.Fail("T_imu_cam", fmt::format("has {} cameras, not 2", poses.size()));
  if (lenses.size() != 2) value.Fail("intrinsics", fmt::format("has {} cameras, not 2", lenses.size()));
  const std::vector<double> sizes = value.Matrix("resolution", 4, 4);
  CameraCalibration cameras[2];
  for (size_t i = 0; i < 2; ++i) {
    cameras[i] = BasaltCamera(lenses[i]);
    cameras[i].T_b_cam = BasaltPose(poses[i]);
    for (size_t side = 0; side < 2; ++side) {
      const double pixels = sizes[2 * i + side];
      if (!IsImageSide(pixels)) {
        value.Fail("resolution", fmt::format("{} is not a whole number of pixels", pixels));
      }
      (side == 0 ? cameras[i].width_px : cameras[i].height_px) = static_cast<int>(pixels);
    }
  }
  ForeignCalibration result;
  result.rig.left = cameras[0];
  result.rig.right = cameras[1];
  result.direction = "T_imu_cam takes points of each camera to the IMU: used as it is";
  return result;
}

}  // namespace plslam
