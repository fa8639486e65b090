// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/datasets/calibrations/readers.h"
#include "core/datasets/check_rig.h"
#include "core/files/dataset_error.h"

namespace plslam {
namespace {

constexpr auto kSidesOfTopics = std::to_array<std::pair<std::string_view, std::string_view>>(
    {{"left", "right"}, {"infra1", "infra2"}, {"fisheye1", "fisheye2"}});

bool AreNamedAsPair(std::string left, const std::string& right) {
  for (const auto& [l, r] : kSidesOfTopics) {
    const size_t at = left.find(l);
    if (at != std::string::npos && left.replace(at, l.size(), r) == right) return true;
  }
  return false;
}

/// Two cameras of one make that look the same way, the one to the right of the other.
bool FormStereoPair(const NamedCamera& left, const NamedCamera& right) {
  constexpr double kSameFocal = 0.03, kSameDirection_rad = 0.2;
  const CameraCalibration &l = left.camera, &r = right.camera;
  const SE3 T_l_r = l.T_b_cam.Inverse() * r.T_b_cam;
  const Eigen::Vector3d& t = T_l_r.translation();
  return l.width_px == r.width_px && l.height_px == r.height_px && l.model == r.model &&
         std::abs(l.fx_px - r.fx_px) <= kSameFocal * l.fx_px && t.x() > 0.9 * t.norm() &&
         T_l_r.Log().tail<3>().norm() <= kSameDirection_rad;
}

}  // namespace

void SetCameraMatrix(const YamlMap& yaml, const char* key, CameraCalibration* camera) {
  const std::vector<double> K = yaml.Matrix(key, 9, 9);
  if (std::all_of(K.begin(), K.end(), [](double k) { return k == 0.0; })) {
    yaml.Fail(key, "is all 0: the camera is not calibrated");
  }
  if (!(std::abs(K[1]) <= kNoSkew_px) || K[3] != 0.0 || K[6] != 0.0 || K[7] != 0.0 || K[8] != 1.0) {
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
  if (!zeros_from(0) && d.size() != 4 && d.size() != 5 && d.size() < kRational) {
    return fmt::format("has {} numbers, not 4, 5 or 8", d.size());
  }
  d.resize(std::min(d.size(), kRational));
  if (d.size() == kRational && zeros_from(5)) d.resize(5);
  if (zeros_from(0)) d.clear();
  camera->model = d.empty()               ? lens_model::kPinhole
                  : d.size() == kRational ? lens_model::kRational
                                          : lens_model::kRadtan;
  camera->distortion = std::move(d);
  return "";
}

void SetOpenCvDistortion(const YamlMap& yaml, const char* key, CameraCalibration* camera) {
  const std::string complaint = SetOpenCvDistortion(yaml.Matrix(key, 0, 14), camera);
  if (!complaint.empty()) yaml.Fail(key, complaint);
}

void SetFocalAndCentre(const YamlMap& file, const std::string& prefix, CameraCalibration* camera) {
  camera->fx_px = file.Number(prefix + "fx");
  camera->fy_px = file.Number(prefix + "fy");
  camera->cx_px = file.Number(prefix + "cx");
  camera->cy_px = file.Number(prefix + "cy");
}

void SetSize(const ImageSize& size, RigCalibration* rig) {
  for (CameraCalibration* camera : {&rig->left, &rig->right}) {
    camera->width_px = size.width_px;
    camera->height_px = size.height_px;
  }
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

CameraPair ChoosePair(const std::vector<NamedCamera>& cameras, const std::string& place) {
  if (cameras.size() < 2) {
    throw DatasetError(fmt::format("{}: has {} camera, but a stereo pair is needed", place, cameras.size()));
  }
  if (cameras.size() == 2) return {0, 1, ""};
  std::vector<CameraPair> pairs;
  for (const bool by_topic : {true, false}) {
    for (size_t l = 0; l < cameras.size(); ++l) {
      for (size_t r = 0; r < cameras.size(); ++r) {
        if (by_topic ? AreNamedAsPair(cameras[l].topic, cameras[r].topic) : FormStereoPair(cameras[l], cameras[r])) {
          pairs.push_back({l, r, ""});
        }
      }
    }
    if (!pairs.empty()) break;
  }
  if (pairs.size() != 1) {
    throw DatasetError(fmt::format("{}: has {} cameras, and {} of them: put the two to use into a separate file",
                                   place, cameras.size(),
                                   pairs.empty() ? "no two are a stereo pair" : "several pairs could be meant"));
  }
  CameraPair& pair = pairs.front();
  std::string others;
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (i != pair.left && i != pair.right) others += (others.empty() ? "" : ", ") + cameras[i].name;
  }
  pair.note = fmt::format("{}: {} and {} are used as the stereo pair, {} {} ignored", place, cameras[pair.left].name,
                          cameras[pair.right].name, others, cameras.size() == 3 ? "is" : "are");
  return pair;
}

SE3 AlongX(double x_m) { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x_m, 0.0, 0.0)}; }

}  // namespace plslam
