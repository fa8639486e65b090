// SPDX-License-Identifier: BSD-3-Clause
// Settings of ORB-SLAM2 and 3, and of stella_vslam, which descends from it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/datasets/calibrations/readers.h"
#include "core/datasets/camera_file.h"

namespace plslam {
namespace {

/// Tolerance for focal lengths of one camera that are given twice.
constexpr double kSameFocal = 1e-3;

std::string In(const std::string& camera, const char* key) { return camera + "." + key; }

/// Intrinsics and distortion of `Camera1.` and so on, as ORB-SLAM3 has them.
CameraCalibration OrbSlamLens(const YamlMap& file, const std::string& camera, const std::string& type) {
  CameraCalibration lens;
  SetFocalAndCentre(file, In(camera, ""), &lens);
  if (type == "Rectified" || !file.Has(In(camera, "k1"))) return lens;
  if (type == "KannalaBrandt8") {
    lens.model = lens_model::kEquidistant;
    for (const char* key : {"k1", "k2", "k3", "k4"}) lens.distortion.push_back(file.Number(In(camera, key)));
    return lens;
  }
  std::vector<double> distortion;
  for (const char* key : {"k1", "k2", "p1", "p2"}) distortion.push_back(file.Number(In(camera, key)));
  // Coefficients up to the last one in the file.
  std::vector<double> higher;
  for (const char* key : {"k6", "k5", "k4", "k3"}) {
    if (!higher.empty() || file.Has(In(camera, key))) higher.push_back(file.Number(In(camera, key)));
  }
  distortion.insert(distortion.end(), higher.rbegin(), higher.rend());
  const std::string complaint = SetOpenCvDistortion(distortion, &lens);
  if (!complaint.empty()) file.Fail(In(camera, "k1"), "and the following: the distortion " + complaint);
  return lens;
}

/// Settings of a rectified pair may keep the distortion of the raw images, which ORB-SLAM3 does not apply either.
void WarnOfDistortion(const YamlMap& file, const std::string& camera, Notes* notes) {
  for (const char* name : {"k1", "k2", "p1", "p2", "k3"}) {
    const std::string key = In(camera, name);
    if (!file.Has(key) || file.Number(key) == 0.0) continue;
    notes->Warn(
        fmt::format("{}: {} = {} is not applied, since Camera.type is Rectified; if the images are not rectified, "
                    "they need Camera.type: PinHole, Camera2 and Stereo.T_c1_c2",
                    file.Place(key), key, file.Number(key)));
    return;
  }
}

ImageSize SizeIn(const YamlMap& file, const char* width, const char* height, const ImageSize& image_size) {
  if (!file.Has(width)) return image_size;
  return {PixelsOf(file, width), PixelsOf(file, height)};
}

double Quotient(const YamlMap& file, const char* numerator, double denominator) {
  const double value = file.Number(numerator);
  if (!(denominator >= 1.0)) file.Fail(numerator, fmt::format("belongs to a focal length of {} pixels", denominator));
  return value / denominator;
}

/// Returns an RGB-D camera; the projector in its settings is `baseline_m` beside it.
ForeignCalibration RgbdCamera(const YamlMap& file, const CameraCalibration& camera, const char* factor,
                              double baseline_m) {
  const double units_per_m = file.Number(factor);
  if (!(units_per_m > 0.0 && units_per_m <= 1e6)) {
    file.Fail(factor, fmt::format("= {} is not above 0 and at most 1000000 units per metre", units_per_m));
  }
  ForeignCalibration result;
  result.rig = MakeRgbdRig(camera, baseline_m, units_per_m);
  result.direction = fmt::format("an RGB-D camera, {} is in units per metre", factor);
  return result;
}

/// ORB-SLAM3 with a version: two cameras, or one that is rectified, or an RGB-D camera.
ForeignCalibration ReadOrbSlam3(const YamlMap& file, const ImageSize& image_size) {
  const std::string type = file.Text("Camera.type");
  if (type != "PinHole" && type != "KannalaBrandt8" && type != "Rectified") {
    file.Fail("Camera.type", fmt::format("'{}' is not one of PinHole, KannalaBrandt8, Rectified", type));
  }
  CameraCalibration left = OrbSlamLens(file, "Camera1", type);
  const ImageSize size = SizeIn(file, "Camera.width", "Camera.height", image_size);
  left.width_px = size.width_px;
  left.height_px = size.height_px;
  ForeignCalibration result;
  if (type == "Rectified") {
    WarnOfDistortion(file, "Camera1", &result.notes);
    result.rig = RigOf(left, left, AlongX(file.Number("Stereo.b")));
    result.direction = "the pair is rectified, Stereo.b is its baseline";
  } else if (file.Has("Camera2.fx")) {
    result.rig = RigOf(left, OrbSlamLens(file, "Camera2", type), file.Transform("Stereo.T_c1_c2"));
    result.direction = "Stereo.T_c1_c2 transforms points from the right camera to the left one: used unchanged";
  } else if (file.Has("RGBD.DepthMapFactor")) {
    result = RgbdCamera(file, left, "RGBD.DepthMapFactor", file.Number("Stereo.b"));
  } else {
    file.Fail("Camera2.fx", "is missing, so that these are settings of a single camera: a stereo pair is needed");
  }
  SetSize(size, &result.rig);
  return result;
}

/// Rejects files that look like the settings of a rectified pair and are not. `keys` are distortions.
template <size_t n>
void RequireRectified(const YamlMap& file, const std::array<const char*, n>& keys, const char* rectifier) {
  for (const char* key : keys) {
    if (!file.Has(key) || file.Number(key) == 0.0) continue;
    file.Fail(key, fmt::format("= {} is not 0 as in a rectified pair, and {}, which rectifies, is missing",
                               file.Number(key), rectifier));
  }
}

/// Two cameras with the matrices that rectify them.
ForeignCalibration ReadRectifying(const YamlMap& file, double baseline_m, const ImageSize& image_size) {
  CameraCalibration left, right;
  SetCameraMatrix(file, "LEFT.K", &left);
  SetOpenCvDistortion(file, "LEFT.D", &left);
  SetCameraMatrix(file, "RIGHT.K", &right);
  SetOpenCvDistortion(file, "RIGHT.D", &right);
  ForeignCalibration result;
  result.rig = RigOf(left, right, LeftFromRight(RotationOf(file, "LEFT.R"), RotationOf(file, "RIGHT.R"), baseline_m));
  SetSize(SizeIn(file, "LEFT.width", "LEFT.height", image_size), &result.rig);
  result.direction = "LEFT.R and RIGHT.R transform points from each camera to its rectified frame";
  return result;
}

/// Settings that were copied and filled in halfway keep the matrices of another camera.
void RequireOwnMatrices(const YamlMap& file) {
  if (!file.Has("LEFT.P")) return;
  const double f_px = file.Number("Camera.fx"), rectified_px = file.Matrix("LEFT.P", 12, 12)[0];
  if (std::abs(f_px - rectified_px) <= kSameFocal * f_px) return;
  file.Fail("Camera.fx", fmt::format("= {} is not the {} of LEFT.P, so LEFT and RIGHT belong to another camera: "
                                     "correct them, or remove them for a rectified pair",
                                     f_px, rectified_px));
}

/// ORB-SLAM2, and 3 before version 1.0: a rectified camera with its baseline times focal length, and, where the images
/// are not rectified yet, the matrices that rectify them; or two cameras and Tlr; or an RGB-D camera.
ForeignCalibration ReadOrbSlam2(const YamlMap& file, const ImageSize& image_size) {
  const std::string type = file.Has("Camera.type") ? file.Text("Camera.type") : "PinHole";
  const ImageSize size = SizeIn(file, "Camera.width", "Camera.height", image_size);
  ForeignCalibration result;
  if (file.Has("Tlr")) {
    result.rig = RigOf(OrbSlamLens(file, "Camera", type), OrbSlamLens(file, "Camera2", type), file.Transform("Tlr"));
    result.direction = "Tlr transforms points from the right camera to the left one: used unchanged";
    SetSize(size, &result.rig);
    return result;
  }
  if (!file.Has("Camera.bf")) {
    file.Fail("Camera.bf", "is missing, so that these are settings of a single camera: a stereo pair is needed");
  }
  const double baseline_m = Quotient(file, "Camera.bf", file.Number("Camera.fx"));
  if (file.Has("LEFT.K")) {
    RequireOwnMatrices(file);
    return ReadRectifying(file, baseline_m, size);
  }
  if (file.Has("DepthMapFactor")) {
    CameraCalibration camera = OrbSlamLens(file, "Camera", type);
    camera.width_px = size.width_px;
    camera.height_px = size.height_px;
    return RgbdCamera(file, camera, "DepthMapFactor", baseline_m);
  }
  if (type == "KannalaBrandt8") {
    file.Fail("Camera.type",
              "= KannalaBrandt8 is not the lens of a rectified pair, and Tlr (with Camera2) is missing");
  }
  RequireRectified(file, std::to_array({"Camera.k1", "Camera.k2", "Camera.p1", "Camera.p2", "Camera.k3"}), "LEFT.K");
  const CameraCalibration left = OrbSlamLens(file, "Camera", "Rectified");
  result.rig = RigOf(left, left, AlongX(baseline_m));
  SetSize(size, &result.rig);
  result.direction = "the pair is rectified, Camera.bf is baseline times focal length";
  return result;
}

/// Requires that settings of stella_vslam are of a rectified pair.
void RequireRectifiedStella(const YamlMap& file) {
  constexpr const char* kModel = "Camera.model";
  if (file.Has(kModel) && file.Text(kModel) != "perspective") {
    file.Fail(kModel, fmt::format("'{}' is not perspective as in a rectified pair, and StereoRectifier is missing",
                                  file.Text(kModel)));
  }
  RequireRectified(file,
                   std::to_array({"Camera.k1", "Camera.k2", "Camera.p1", "Camera.p2", "Camera.k3", "Camera.k4"}),
                   "StereoRectifier");
}

CameraCalibration StellaLens(const YamlMap& file, const std::string& side, const std::string& model) {
  CameraCalibration camera;
  const std::string matrix = "StereoRectifier.K_" + side, distortion = "StereoRectifier.D_" + side;
  SetCameraMatrix(file, matrix.c_str(), &camera);
  if (model == "fisheye") {
    camera.model = lens_model::kEquidistant;
    camera.distortion = file.Matrix(distortion, 4, 4);
  } else {
    SetOpenCvDistortion(file, distortion.c_str(), &camera);
  }
  return camera;
}

}  // namespace

ForeignCalibration ReadOrbSlam(const YamlMap& file, const ImageSize& image_size) {
  ForeignCalibration result =
      file.Has("Camera1.fx") ? ReadOrbSlam3(file, image_size) : ReadOrbSlam2(file, image_size);
  if (file.Has("Camera.fps")) result.rig.rate_hz = file.Number("Camera.fps");
  return result;
}

namespace {

/// The depth factor is below `Preprocessing`, or, in earlier versions, below no other key or `Camera`.
ForeignCalibration ReadStellaRgbd(const YamlMap& file, const ImageSize& image_size) {
  constexpr const char* kModel = "Camera.model";
  if (file.Has(kModel) && file.Text(kModel) != "perspective") {
    file.Fail(kModel, fmt::format("'{}' is not perspective, as depth maps need", file.Text(kModel)));
  }
  CameraCalibration camera = OrbSlamLens(file, "Camera", "PinHole");
  const ImageSize size = SizeIn(file, "Camera.cols", "Camera.rows", image_size);
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  const char* factor = "Preprocessing.depthmap_factor";
  for (const char* key : {"depthmap_factor", "Camera.depthmap_factor"}) {
    if (!file.Has(factor) && file.Has(key)) factor = key;
  }
  const double baseline_m = Quotient(file, "Camera.focal_x_baseline", camera.fx_px);
  ForeignCalibration result = RgbdCamera(file, camera, factor, baseline_m);
  if (file.Has("Camera.fps")) result.rig.rate_hz = file.Number("Camera.fps");
  return result;
}

}  // namespace

// Keys of later versions are below `Camera:`, those of earlier ones are `Camera.fx:`.
ForeignCalibration ReadStella(const YamlMap& file, const ImageSize& image_size) {
  const std::string setup = file.Text("Camera.setup");
  if (setup == "RGBD") return ReadStellaRgbd(file, image_size);
  if (setup != "stereo") {
    file.Fail("Camera.setup",
              fmt::format("'{}' is neither stereo nor RGBD: the settings of a stereo pair or a depth camera "
                          "are needed",
                          setup));
  }
  const double baseline_m = Quotient(file, "Camera.focal_x_baseline", file.Number("Camera.fx"));
  ForeignCalibration result;
  if (!file.Has("StereoRectifier.K_left")) {
    RequireRectifiedStella(file);
    CameraCalibration left;
    SetFocalAndCentre(file, "Camera.", &left);
    result.rig = RigOf(left, left, AlongX(baseline_m));
    result.direction = "the pair is rectified, focal_x_baseline is focal length times baseline";
  } else {
    const std::string model =
        file.Has("StereoRectifier.model") ? file.Text("StereoRectifier.model") : std::string("perspective");
    if (model != "fisheye" && model != "perspective") {
      file.Fail("StereoRectifier.model", fmt::format("'{}' is not one of perspective, fisheye", model));
    }
    result.rig = RigOf(StellaLens(file, "left", model), StellaLens(file, "right", model),
                       LeftFromRight(RotationOf(file, "StereoRectifier.R_left"),
                                     RotationOf(file, "StereoRectifier.R_right"), baseline_m));
    result.direction = "R_left and R_right transform points from each camera to its rectified frame";
  }
  SetSize(SizeIn(file, "Camera.cols", "Camera.rows", image_size), &result.rig);
  if (file.Has("Camera.fps")) result.rig.rate_hz = file.Number("Camera.fps");
  return result;
}

}  // namespace plslam
