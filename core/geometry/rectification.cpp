// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/rectification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace plslam {
namespace {

constexpr double kNegligible_px = 0.01;
constexpr double kLargestHalfFov_rad = 50.0 * std::numbers::pi / 180.0;
constexpr double kLargestMagnification = 1.3;
// Largest angle between the optical axes of a usable pair.
constexpr double kLargestAxisAngle_rad = 60.0 * std::numbers::pi / 180.0;
constexpr int kBorderSamples = 32;

// The largest rectangle on the plane z = 1 that all raw images cover.
struct Window {
  double x0 = -1e3;
  double x1 = 1e3;
  double y0 = -1e3;
  double y1 = 1e3;
};

/// Direction of the x axis of the rectified images in the raw ones.
enum class RowDirection { kRight, kDown, kUp };

/// The raw image rotated in quarter turns so that rows run along the baseline.
struct TurnedImage {
  RowDirection rows = RowDirection::kRight;
  int raw_width_px = 0;
  int raw_height_px = 0;

  bool IsTurned() const { return rows != RowDirection::kRight; }
  int width_px() const { return IsTurned() ? raw_height_px : raw_width_px; }
  int height_px() const { return IsTurned() ? raw_width_px : raw_height_px; }
  Eigen::Vector2d RawPixel(double u, double v) const {
    if (rows == RowDirection::kDown) return {raw_width_px - 1.0 - v, u};
    if (rows == RowDirection::kUp) return {v, raw_height_px - 1.0 - u};
    return {u, v};
  }
};

template <class... Parts>
std::runtime_error Error(const RigCalibration& rig, const Parts&... parts) {
  std::ostringstream text;
  text << "rig \"" << rig.name << "\": ";
  (text << ... << parts);
  return std::runtime_error(text.str());
}

void CheckCamera(const RigCalibration& rig, const CameraCalibration& c, const char* side) {
  if (c.width_px <= 0 || c.height_px <= 0) {
    throw Error(rig, side, " image size is ", c.width_px, "x", c.height_px, ", expected positive numbers");
  }
  const double values[] = {c.fx_px, c.fy_px, c.cx_px, c.cy_px};
  const bool finite = std::all_of(values, values + 4, [](double v) { return std::isfinite(v); });
  if (!finite || c.fx_px <= 0.0 || c.fy_px <= 0.0) {
    throw Error(rig, side, " intrinsics are fx ", c.fx_px, " fy ", c.fy_px, " cx ", c.cx_px, " cy ", c.cy_px,
                ", expected finite numbers and positive focal lengths");
  }
  if (!c.T_b_cam.IsFinite()) throw Error(rig, side, " camera pose contains a value that is not a number");
}

RowDirection RowsAlong(const Eigen::Vector3d& baseline) {
  if (std::abs(baseline.x()) >= std::abs(baseline.y())) return RowDirection::kRight;
  return baseline.y() > 0.0 ? RowDirection::kDown : RowDirection::kUp;
}

double BaselineOf(const RigCalibration& rig, const SE3& T_l_r) {
  const Eigen::Vector3d& t = T_l_r.translation();
  const double length = t.norm();
  if (!(length > 1e-6)) throw Error(rig, "left and right camera are at the same position");
  if (std::abs(t.z()) > std::max(std::abs(t.x()), std::abs(t.y()))) {
    throw Error(
        rig, "the right camera is at (", t.x(), ", ", t.y(), ", ", t.z(),
        ") m relative to the left one; only cameras beside each other (along x) or one above the other (along y) are "
        "supported");
  }
  if (t.x() < 0.0 && RowsAlong(t) == RowDirection::kRight) {
    throw Error(rig, "the right camera is at x = ", t.x(),
                " m relative to the left one, so left and right are exchanged");
  }
  return length;
}

Eigen::Quaterniond SharedOrientation(const RigCalibration& rig, const SE3& T_l_r) {
  const Eigen::Vector3d left_axis = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d right_axis = T_l_r.rotation() * Eigen::Vector3d::UnitZ();
  const double angle = std::acos(std::clamp(left_axis.dot(right_axis), -1.0, 1.0));
  if (angle > kLargestAxisAngle_rad) {
    throw Error(rig, "the optical axes of left and right camera are ", angle * 180.0 / std::numbers::pi,
                " deg apart, at most ", kLargestAxisAngle_rad * 180.0 / std::numbers::pi, " can be rectified");
  }
  Eigen::Matrix3d R_l_c;
  R_l_c.col(0) = T_l_r.translation().normalized();
  R_l_c.col(1) = (left_axis + right_axis).cross(R_l_c.col(0)).normalized();
  R_l_c.col(2) = R_l_c.col(0).cross(R_l_c.col(1));
  return Eigen::Quaterniond(R_l_c).normalized();
}

// Whether deviations from an ideal pair are negligible, in pixels at the border of the image.
bool IsIdeal(const CameraCalibration& c, const CameraCalibration& reference, const Eigen::Quaterniond& q_raw_c) {
  const double half_size = 0.5 * std::max(c.width_px, c.height_px);
  const double turn_px = q_raw_c.angularDistance(Eigen::Quaterniond::Identity()) * (c.fx_px + half_size);
  const double focal_px = (std::abs(c.fx_px - reference.fx_px) + std::abs(c.fy_px - reference.fx_px)) / c.fx_px;
  const double center_px = std::abs(c.cx_px - reference.cx_px) + std::abs(c.cy_px - reference.cy_px);
  return Distortion(c).IsIdentity() && turn_px + focal_px * half_size + center_px < kNegligible_px;
}

// Reduces `window` to the region inside the border of one raw image. A border beyond the lens model is no limit.
void Shrink(const RectifiedView& view, const TurnedImage& image, Window& window) {
  const double right = image.width_px() - 1.0;
  const double bottom = image.height_px() - 1.0;
  const auto point = [&](double u, double v) { return view.RectifiedPoint(image.RawPixel(u, v)); };
  for (int i = 0; i <= kBorderSamples; ++i) {
    const double u = right * i / kBorderSamples;
    const double v = bottom * i / kBorderSamples;
    if (const auto p = point(0.0, v)) window.x0 = std::max(window.x0, p->x());
    if (const auto p = point(right, v)) window.x1 = std::min(window.x1, p->x());
    if (const auto p = point(u, 0.0)) window.y0 = std::max(window.y0, p->y());
    if (const auto p = point(u, bottom)) window.y1 = std::min(window.y1, p->y());
  }
}

// Returns the middle of [from, to], moved towards straight ahead as far as the lens covers the view.
double Middle(double from, double to, double half_extent) {
  return std::clamp(0.0, std::min(from + half_extent, 0.5 * (from + to)),
                    std::max(to - half_extent, 0.5 * (from + to)));
}

StereoCamera ChooseCamera(const RigCalibration& rig, const TurnedImage& image, const Window& window,
                          double baseline_m) {
  const double width = image.width_px() - 1.0;
  const double height = image.height_px() - 1.0;
  // Focal lengths in the centre of the images.
  const double l = Distortion(rig.left).CentreScale();
  const double r = rig.kind == RigCalibration::Kind::kRgbd ? l : Distortion(rig.right).CentreScale();
  const double raw_f =
      rig.kind == RigCalibration::Kind::kRgbd
          ? 0.5 * (l * rig.left.fx_px + l * rig.left.fy_px)
          : 0.25 * (l * rig.left.fx_px + l * rig.left.fy_px + r * rig.right.fx_px + r * rig.right.fy_px);
  if (window.x1 <= window.x0 || window.y1 <= window.y0) {
    throw Error(rig, "left and right camera have no common view; check intrinsics, distortion and extrinsics");
  }
  const double no_border = std::max(width / (window.x1 - window.x0), height / (window.y1 - window.y0));
  const double narrow_enough = 0.5 * std::max(width, height) / std::tan(kLargestHalfFov_rad);
  const double magnified = kLargestMagnification * raw_f;
  StereoCamera camera;
  camera.f_px = std::max(std::min(no_border, magnified), narrow_enough);
  const double x = Middle(window.x0, window.x1, 0.5 * width / camera.f_px);
  const double y = Middle(window.y0, window.y1, 0.5 * height / camera.f_px);
  camera.cx_px = 0.5 * width - camera.f_px * x;
  camera.cy_px = 0.5 * height - camera.f_px * y;
  camera.baseline_m = baseline_m;
  camera.width_px = image.width_px();
  camera.height_px = image.height_px();
  return camera;
}

}  // namespace

RectifiedView::RectifiedView(const CameraCalibration& calibration, const Eigen::Quaterniond& q_raw_c)
    : calibration_(calibration), distortion_(calibration), R_raw_c_(q_raw_c.toRotationMatrix()) {}

std::optional<Eigen::Vector2d> RectifiedView::RawPixel(const StereoCamera& camera,
                                                       const Eigen::Vector2d& rectified_px) const {
  Eigen::Vector2d px = rectified_px;
  ToRawPixels(camera, {&px.x(), 1}, {&px.y(), 1});
  return px.allFinite() ? std::optional(px) : std::nullopt;
}

void RectifiedView::ToRawPixels(const StereoCamera& camera, std::span<double> x, std::span<double> y) const {
  const Eigen::Matrix3d& R = R_raw_c_;
  for (size_t i = 0; i < x.size(); ++i) {
    const double a = (x[i] - camera.cx_px) / camera.f_px;
    const double b = (y[i] - camera.cy_px) / camera.f_px;
    const double z = R(2, 0) * a + R(2, 1) * b + R(2, 2);
    const double depth = z > 1e-6 ? z : std::numeric_limits<double>::quiet_NaN();
    x[i] = (R(0, 0) * a + R(0, 1) * b + R(0, 2)) / depth;
    y[i] = (R(1, 0) * a + R(1, 1) * b + R(1, 2)) / depth;
  }
  distortion_.Distort(x, y);
  for (size_t i = 0; i < x.size(); ++i) {
    x[i] = calibration_.fx_px * x[i] + calibration_.cx_px;
    y[i] = calibration_.fy_px * y[i] + calibration_.cy_px;
  }
}

std::optional<Eigen::Vector2d> RectifiedView::RectifiedPoint(const Eigen::Vector2d& raw_px) const {
  const auto xy = distortion_.Undistort({(raw_px.x() - calibration_.cx_px) / calibration_.fx_px,
                                         (raw_px.y() - calibration_.cy_px) / calibration_.fy_px});
  if (!xy) return std::nullopt;
  const Eigen::Vector3d ray = R_raw_c_.transpose() * xy->homogeneous();
  if (!(ray.z() > 1e-6)) return std::nullopt;
  return Eigen::Vector2d(ray.head<2>() / ray.z());
}

Rectification Rectify(const RigCalibration& rig) {
  const bool rgbd = rig.kind == RigCalibration::Kind::kRgbd;
  CheckCamera(rig, rig.left, "left");
  const CameraCalibration& right = rgbd ? rig.left : rig.right;
  CheckCamera(rig, right, "right");
  if (right.width_px != rig.left.width_px || right.height_px != rig.left.height_px) {
    throw Error(rig, "left images are ", rig.left.width_px, "x", rig.left.height_px, " and right ones ",
                right.width_px, "x", right.height_px, ", expected equal sizes");
  }
  if (rgbd && !(rig.baseline_m > 0.0)) {
    throw Error(rig, "the virtual baseline is ", rig.baseline_m, " m, expected a positive number");
  }
  const SE3 T_l_r = rgbd ? SE3(Eigen::Quaterniond::Identity(), {rig.baseline_m, 0.0, 0.0})
                         : rig.left.T_b_cam.Inverse() * rig.right.T_b_cam;
  const double baseline_m = BaselineOf(rig, T_l_r);
  const Eigen::Quaterniond q_l_c = SharedOrientation(rig, T_l_r);
  const Eigen::Quaterniond q_r_c = T_l_r.rotation().conjugate() * q_l_c;

  Rectification result{{}, q_l_c, RectifiedView(rig.left, q_l_c), RectifiedView(right, q_r_c), false};
  if (IsIdeal(rig.left, rig.left, q_l_c) && IsIdeal(right, rig.left, q_r_c)) {
    result.identity = true;
    result.q_l_c = Eigen::Quaterniond::Identity();
    result.camera = {rig.left.fx_px, rig.left.cx_px,    rig.left.cy_px,
                     baseline_m,     rig.left.width_px, rig.left.height_px};
    return result;
  }
  const TurnedImage image{RowsAlong(T_l_r.translation()), rig.left.width_px, rig.left.height_px};
  Window window;
  Shrink(result.left, image, window);
  Shrink(result.right, image, window);
  result.camera = ChooseCamera(rig, image, window, baseline_m);
  return result;
}

}  // namespace plslam
