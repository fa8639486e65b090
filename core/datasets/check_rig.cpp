// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/check_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/distortion.h"

namespace plslam {
namespace {

constexpr int kMinSize_px = 16;
constexpr double kMinFocal_px = 1.0;
constexpr double kMaxFocal_px = 1e5;
constexpr double kMaxDistortion = 1e4;
constexpr double kMinBaseline_m = 1e-4;
constexpr double kMaxAngle_rad = 0.785398163397448;

// Comparisons with NaN are false, so the test is for "inside", never for "outside".
bool Inside(double value, double min, double max) { return value >= min && value <= max; }

std::string OneFocalComplaint(double value, const char* key) {
  if (Inside(value, kMinFocal_px, kMaxFocal_px)) return "";
  return fmt::format("focal length {} = {} is not within {} to {} pixels", key, value, kMinFocal_px, kMaxFocal_px);
}

std::string OneCentreComplaint(double value, int size_px, const char* key) {
  if (Inside(value, -size_px, 2.0 * size_px)) return "";
  return fmt::format("principal point {} = {} is not within {} to {} pixels", key, value, -size_px, 2 * size_px);
}

std::string FirstOf(std::initializer_list<std::string> complaints) {
  const auto first = std::find_if(complaints.begin(), complaints.end(), [](const auto& s) { return !s.empty(); });
  return first == complaints.end() ? "" : *first;
}

}  // namespace

bool IsImageSide(double side_px) {
  return side_px >= 1.0 && side_px <= kMaxImageSide_px && side_px == std::floor(side_px);
}

std::string SizeComplaint(const CameraCalibration& camera) {
  if (Inside(camera.width_px, kMinSize_px, kMaxImageSide_px) &&
      Inside(camera.height_px, kMinSize_px, kMaxImageSide_px)) {
    return "";
  }
  return fmt::format("image size {} x {} is not within {} to {} pixels", camera.width_px, camera.height_px,
                     kMinSize_px, kMaxImageSide_px);
}

std::string FocalComplaint(const CameraCalibration& camera) {
  return FirstOf({OneFocalComplaint(camera.fx_px, "fx"), OneFocalComplaint(camera.fy_px, "fy")});
}

std::string CentreComplaint(const CameraCalibration& camera) {
  return FirstOf({OneCentreComplaint(camera.cx_px, camera.width_px, "cx"),
                  OneCentreComplaint(camera.cy_px, camera.height_px, "cy")});
}

std::string ModelComplaint(const CameraCalibration& camera) {
  if (FindLensModel(camera.model) != nullptr) return "";
  return fmt::format("model '{}' is not one of {}", camera.model, LensModelNames());
}

std::string DistortionComplaint(const CameraCalibration& camera) {
  const size_t n = camera.distortion.size();
  const LensModel* model = FindLensModel(camera.model);
  if (model == nullptr) return ModelComplaint(camera);
  if (camera.model == lens_model::kPinhole && n != 0)
    return fmt::format("model pinhole has no distortion, but {} are given", n);
  if (!LensModelTakes(camera.model, n)) {
    const std::string bound = model->min_coefficients == model->max_coefficients
                                  ? fmt::format("{}", model->min_coefficients)
                                  : fmt::format("{} or {}", model->min_coefficients, model->max_coefficients);
    return fmt::format("model {} has {} distortions ({}), not {}", camera.model, bound, model->coefficients, n);
  }
  if (camera.model == lens_model::kDoubleSphere) {
    if (!Inside(camera.distortion[0], -0.99, 10.0)) {
      return fmt::format("xi {} is not within -0.99 to 10", camera.distortion[0]);
    }
    if (!Inside(camera.distortion[1], 0.0, 1.0))
      return fmt::format("alpha {} is not within 0 to 1", camera.distortion[1]);
  }
  for (const double k : camera.distortion) {
    if (!Inside(k, -kMaxDistortion, kMaxDistortion)) {
      return fmt::format("distortion {} is not within -{} to {}", k, kMaxDistortion, kMaxDistortion);
    }
  }
  return "";
}

namespace {

std::string CameraComplaint(const CameraCalibration& camera, const char* side) {
  const std::string complaint =
      FirstOf({SizeComplaint(camera), FocalComplaint(camera), CentreComplaint(camera), ModelComplaint(camera),
               DistortionComplaint(camera), camera.T_b_cam.IsFinite() ? "" : "the pose is not finite"});
  return complaint.empty() ? "" : fmt::format("{} camera: {}", side, complaint);
}

std::string PlacementComplaint(const RigCalibration& rig) {
  const SE3 T_l_r = rig.left.T_b_cam.Inverse() * rig.right.T_b_cam;
  const double distance_m = T_l_r.translation().norm();
  if (!Inside(rig.baseline_m, kMinBaseline_m, kMaxBaseline_m) ||
      !(std::abs(rig.baseline_m - distance_m) <= 1e-6 * distance_m + 1e-9)) {
    return fmt::format("baseline {} m (distance of the cameras {} m) is not within {} to {} m{}", rig.baseline_m,
                       distance_m, kMinBaseline_m, kMaxBaseline_m,
                       distance_m > kMaxBaseline_m ? "; is it in millimetres?" : "");
  }
  const Eigen::Vector3d& t = T_l_r.translation();
  const bool is_above = std::abs(t.y()) > std::abs(t.x()) && std::abs(t.y()) > 0.5 * distance_m;
  if (!is_above && !(t.x() > 0.5 * distance_m)) {
    return fmt::format(
        "the right camera must be to the right of the left one, but is at x = {} m, y = {} m, z = {} m; is the "
        "pose of a camera (T_b_cam, T_BS, T_cam_imu) inverted, or are left and right exchanged?",
        t.x(), t.y(), t.z());
  }
  const double angle_rad = T_l_r.Log().tail<3>().norm();
  if (!(angle_rad <= kMaxAngle_rad)) {
    return fmt::format("the optical axes differ by {:.3f} rad, more than {:.3f} rad", angle_rad, kMaxAngle_rad);
  }
  return "";
}

std::string KindComplaint(const RigCalibration& rig) {
  if (rig.left.width_px != rig.right.width_px || rig.left.height_px != rig.right.height_px) {
    return fmt::format("the left camera has {} x {} pixels, the right one {} x {}", rig.left.width_px,
                       rig.left.height_px, rig.right.width_px, rig.right.height_px);
  }
  if (rig.kind == RigCalibration::Kind::kRgbd && !Inside(rig.depth_units_per_m, 1e-3, 1e6)) {
    return fmt::format("depth units per metre {} are not within 0.001 to 1000000", rig.depth_units_per_m);
  }
  return "";
}

}  // namespace

std::string RigComplaint(const RigCalibration& rig) {
  return FirstOf({CameraComplaint(rig.left, "left"), CameraComplaint(rig.right, "right"), KindComplaint(rig),
                  PlacementComplaint(rig)});
}

void WarnOfLongBaseline(const std::string& path, const RigCalibration& rig, const std::string& remedy, Notes* notes) {
  if (rig.kind == RigCalibration::Kind::kRgbd || rig.baseline_m <= kUsualBaseline_m) return;
  notes->Warn(fmt::format("{}: the cameras are {:.4g} m apart: {}", path, rig.baseline_m, remedy));
}

void WarnOfOtherScale(const std::string& what, const RigCalibration& rig, Notes* notes) {
  constexpr double kLeast = 0.3, kMost = 0.7, kSamePart = 0.1;
  for (const CameraCalibration* camera : {&rig.left, &rig.right}) {
    const double x = camera->cx_px / camera->width_px, y = camera->cy_px / camera->height_px;
    const bool is_far = (x < kLeast && y < kLeast) || (x > kMost && y > kMost);
    if (!is_far || std::abs(x - y) > kSamePart * (x + y)) continue;
    notes->Warn(fmt::format(
        "{}: the principal point of the {} camera, {:.1f}, {:.1f}, is not near the middle of {} x {} pixels: "
        "it seems to be of images {:.2g} times as large; calibrate with images of this size, or scale focal "
        "length and principal point",
        what, camera == &rig.left ? "left" : "right", camera->cx_px, camera->cy_px, camera->width_px,
        camera->height_px, x + y));
    return;
  }
}

}  // namespace plslam
