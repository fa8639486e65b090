// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <map>

#include "core/datasets/calibrations/readers.h"

namespace plslam {
namespace {

constexpr double kMetresPerCm = 1e-2;
/// Sockets of the left and the right camera where the file does not name them.
constexpr int kLeftSocket = 1, kRightSocket = 2;

/// Returns whether a camera is a fisheye, or else a pinhole. The library writes `cameraType` as a number or a name.
bool IsFisheye(const YamlMap& file) {
  const std::string type = file.Text("cameraType");
  if (type == "1" || type == "Fisheye") return true;
  if (type == "0" || type == "Perspective") return false;
  file.Fail("cameraType",
            fmt::format("= {} is neither 0 (perspective) nor 1 (fisheye): calibrate with one of them", type));
}

CameraCalibration Lens(const YamlMap& file) {
  CameraCalibration camera;
  camera.width_px = PixelsOf(file, "width");
  camera.height_px = PixelsOf(file, "height");
  SetCameraMatrix(file, "intrinsicMatrix", &camera);
  if (IsFisheye(file)) {
    std::vector<double> distortion = file.Numbers("distortionCoeff", 4, 14);
    distortion.resize(4);
    camera.model = lens_model::kEquidistant;
    camera.distortion = distortion;
  } else {
    SetOpenCvDistortion(file, "distortionCoeff", &camera);
  }
  return camera;
}

int SocketOf(const YamlMap& file, const char* key, int fallback) {
  if (!file.Has(key)) return fallback;
  const double socket = file.Number(key);
  return socket >= 0.0 && socket <= 100.0 ? static_cast<int>(socket) : fallback;
}

/// Returns the camera of `toCameraSocket` from this one.
SE3 ToNext(const YamlMap& file) {
  const Eigen::Vector3d t_cm(file.Number("extrinsics.translation.x"), file.Number("extrinsics.translation.y"),
                             file.Number("extrinsics.translation.z"));
  return {RotationOf(file, "extrinsics.rotationMatrix"), kMetresPerCm * t_cm};
}

/// The camera at the end of the chain of extrinsics that leads on from `socket`, and its pose from that one.
struct Origin {
  int socket = 0;
  SE3 T_origin_cam;
};

Origin OriginOf(const YamlMap& file, const std::map<int, YamlMap>& cameras, int socket) {
  Origin origin{socket, {}};
  for (size_t steps = 0; steps <= cameras.size(); ++steps) {
    const YamlMap& camera = cameras.at(origin.socket);
    const int next = SocketOf(camera, "extrinsics.toCameraSocket", -1);
    if (!cameras.contains(next)) return origin;
    origin.T_origin_cam = ToNext(camera) * origin.T_origin_cam;
    origin.socket = next;
  }
  file.Fail("cameraData", "has circular extrinsics");
}

}  // namespace

ForeignCalibration ReadDepthAi(const YamlMap& file) {
  std::map<int, YamlMap> cameras;
  for (const auto& [socket, camera] : file.NumberedMaps("cameraData")) cameras.emplace(socket, camera);
  const int left = SocketOf(file, "stereoRectificationData.leftCameraSocket", kLeftSocket);
  const int right = SocketOf(file, "stereoRectificationData.rightCameraSocket", kRightSocket);
  for (const int socket : {left, right}) {
    if (!cameras.contains(socket)) file.Fail("cameraData", fmt::format("has no camera of socket {}", socket));
  }
  const Origin of_left = OriginOf(file, cameras, left), of_right = OriginOf(file, cameras, right);
  if (of_left.socket != of_right.socket) {
    file.Fail("cameraData", "has no extrinsics from the left camera to the right one");
  }
  ForeignCalibration result;
  result.rig =
      RigOf(Lens(cameras.at(left)), Lens(cameras.at(right)), of_left.T_origin_cam.Inverse() * of_right.T_origin_cam);
  result.direction = "extrinsics, in centimetres, transform points from a camera to that of toCameraSocket";
  result.has_own_unit = true;
  return result;
}

}  // namespace plslam
