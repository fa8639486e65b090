// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "core/datasets/recordings/ros_messages.h"
#include "core/files/dataset_error.h"
#include "core/ros/ros_messages.h"

namespace plslam {
namespace {

CameraCalibration CameraWith(const std::string& model, const std::vector<double>& distortion) {
  CameraCalibration camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = 400.0;
  camera.fy_px = 401.0;
  camera.cx_px = 320.0;
  camera.cy_px = 240.0;
  camera.model = model;
  camera.distortion = distortion;
  return camera;
}

/// Returns the camera that a reader parses from the camera_info of a lens; the right camera is 0.1 m beside it.
CameraCalibration ReadBack(const CameraCalibration& camera) {
  const std::string cdr = RosCameraInfoMessage(0, camera);
  const RosCameraInfo left =
      ParseCameraInfo({reinterpret_cast<const uint8_t*>(cdr.data()), cdr.size()}, RosEncoding::kCdr);
  RosCameraInfo right = left;
  right.P(0, 3) = -0.1 * right.P(0, 0);
  return RigFromRos(left, right, false).left;
}

TEST(CameraInfo, EveryRosLensModelIsReadBack) {
  const std::vector<CameraCalibration> cameras{
      CameraWith("pinhole", {}), CameraWith("radtan", {-0.2, 0.05, 0.001, -0.002, 0.01}),
      CameraWith("rational", {0.3, -0.1, 0.001, -0.002, 0.02, 0.4, -0.05, 0.01}),
      CameraWith("equidistant", {-0.02, 0.01, -0.006, 0.001})};
  for (const CameraCalibration& camera : cameras) {
    const CameraCalibration read = ReadBack(camera);
    EXPECT_EQ(read.model, camera.model);
    EXPECT_EQ(read.distortion, camera.distortion) << camera.model;
    EXPECT_EQ(read.fy_px, camera.fy_px);
    EXPECT_EQ(read.width_px, camera.width_px);
  }
}

TEST(CameraInfo, DoubleSphereIsRefused) {
  EXPECT_THROW(ReadBack(CameraWith("double_sphere", {-0.2, 0.6})), DatasetError);
}

}  // namespace
}  // namespace plslam
