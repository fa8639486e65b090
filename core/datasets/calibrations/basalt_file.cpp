// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"

namespace plslam {
namespace {

/// One of Basalt's cameras, by its kind.
CameraCalibration BasaltCamera(const YamlMap& file) {
  const std::string type = file.Text("camera_type");
  const YamlMap values = file.Map("intrinsics");
  CameraCalibration camera;
  SetFocalAndCentre(values, "", &camera);
  std::vector<const char*> coefficients;
  if (type == "ds") {
    camera.model = lens_model::kDoubleSphere;
    coefficients = {"xi", "alpha"};
  } else if (type == "kb4") {
    camera.model = lens_model::kEquidistant;
    coefficients = {"k1", "k2", "k3", "k4"};
  } else if (type == "pinhole-radtan8") {
    camera.model = lens_model::kRational;
    coefficients = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  } else if (type != "pinhole") {
    file.Fail("camera_type",
              fmt::format("'{}' is not one of pinhole, pinhole-radtan8, kb4, ds: calibrate with one of them", type));
  }
  for (const char* key : coefficients) camera.distortion.push_back(values.Number(key));
  file.Require("intrinsics", DistortionComplaint(camera));
  return camera;
}

SE3 BasaltPose(const YamlMap& pose) {
  const Eigen::Quaterniond q(pose.Number("qw"), pose.Number("qx"), pose.Number("qy"), pose.Number("qz"));
  if (!(std::abs(q.norm() - 1.0) < 1e-3)) {
    pose.Fail("qw", fmt::format("is part of a quaternion of length {:.6g}, expected 1", q.norm()));
  }
  return {q, Eigen::Vector3d(pose.Number("px"), pose.Number("py"), pose.Number("pz"))};
}

}  // namespace

ForeignCalibration ReadBasalt(const YamlMap& file) {
  const YamlMap value = file.Map("value0");
  const std::vector<YamlMap> poses = value.Maps("T_imu_cam"), lenses = value.Maps("intrinsics");
  const size_t n = lenses.size();
  if (poses.size() != n) value.Fail("T_imu_cam", fmt::format("has {} cameras, intrinsics {}", poses.size(), n));
  const std::vector<double> sizes = value.Matrix("resolution", 2 * n, 2 * n);
  std::vector<NamedCamera> cameras;
  for (size_t i = 0; i < n; ++i) {
    CameraCalibration camera = BasaltCamera(lenses[i]);
    camera.T_b_cam = BasaltPose(poses[i]);
    for (size_t side = 0; side < 2; ++side) {
      const double pixels = sizes[2 * i + side];
      if (!IsImageSide(pixels)) {
        value.Fail("resolution", fmt::format("{} is not a whole number of pixels", pixels));
      }
      (side == 0 ? camera.width_px : camera.height_px) = static_cast<int>(pixels);
    }
    cameras.push_back({fmt::format("camera {}", i), "", std::move(camera)});
  }
  const CameraPair pair = ChoosePair(cameras, value.Place("intrinsics"));
  ForeignCalibration result;
  if (!pair.note.empty()) result.notes.Remark(pair.note);
  result.rig.left = cameras[pair.left].camera;
  result.rig.right = cameras[pair.right].camera;
  result.direction = "T_imu_cam transforms points from each camera to the IMU: used unchanged";
  return result;
}

}  // namespace plslam
