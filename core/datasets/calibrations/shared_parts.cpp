// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"

namespace plslam {

void SetCameraMatrix(const YamlMap& yaml, const char* key, CameraCalibration* camera) {
  const std::vector<double> K = yaml.Matrix(key, 9, 9);
  if (K[1] != 0.0 || K[3] != 0.0 || K[6] != 0.0 || K[7] != 0.0 || K[8] != 1.0) {
    yaml.Fail(key, "is no camera matrix fx 0 cx, 0 fy cy, 0 0 1 (skew is not supported)");
  }
  camera->fx_px = K[0];
  camera->cx_px = K[2];
  camera->fy_px = K[4];
  camera->cy_px = K[5];
}

std::string SetOpenCvDistortion(std::vector<double> d, CameraCalibration* camera) {
  constexpr size_t kRational = 8;
  const auto zeros_from = [&d](size_t first) {
    return first >= d.size() ||
           std::all_of(d.begin() + static_cast<std::ptrdiff_t>(first), d.end(), [](double k) { return k == 0.0; });
  };
  if (d.size() > kRational && !zeros_from(kRational)) {
    return "has terms for a thin prism or a tilted sensor, which are not supported: calibrate without them";
  }
  if (d.size() != 4 && d.size() != 5 && d.size() < kRational) {
    return fmt::format("has {} numbers, not 4, 5 or 8", d.size());
  }
  d.resize(std::min(d.size(), kRational));
  if (d.size() == kRational && zeros_from(5)) d.resize(5);
  if (zeros_from(0)) d.clear();
  camera->model = d.empty() ? "pinhole" : d.size() == kRational ? "rational" : "radtan";
  camera->distortion = std::move(d);
  return "";
}

void SetOpenCvDistortion(const YamlMap& yaml, const char* key, CameraCalibration* camera) {
  const std::string complaint = SetOpenCvDistortion(yaml.Matrix(key, 4, 14), camera);
  if (!complaint.empty()) yaml.Fail(key, complaint);
}

Eigen::Matrix3d RotationOf(const YamlMap& yaml, const char* key) {
  const std::vector<double> r = yaml.Matrix(key, 9, 9);
  SE3 T;
  const std::string complaint =
      TransformFrom({r[0], r[1], r[2], 0.0, r[3], r[4], r[5], 0.0, r[6], r[7], r[8], 0.0}, &T);
  if (!complaint.empty()) yaml.Fail(key, complaint);
  return T.R();
}

SE3 LeftFromRight(const Eigen::Matrix3d& R_left, const Eigen::Matrix3d& R_right, double baseline_m) {
  return {Eigen::Matrix3d(R_left.transpose() * R_right), R_left.transpose() * Eigen::Vector3d(baseline_m, 0.0, 0.0)};
}

int PixelsOf(const YamlMap& yaml, const char* key) {
  const double value = yaml.Number(key);
  if (!IsImageSide(value)) {
    yaml.Fail(key, fmt::format("= {} is not a whole number from 1 to {}", value, kMaxImageSide_px));
  }
  return static_cast<int>(value);
}

RigCalibration RigOf(const CameraCalibration& left, const CameraCalibration& right, const SE3& T_left_right) {
  RigCalibration rig;
  rig.left = left;
  rig.right = right;
  rig.right.T_b_cam = left.T_b_cam * T_left_right;
  return rig;
}

SE3 AlongX(double x_m) { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x_m, 0.0, 0.0)}; }

}  // namespace plslam
