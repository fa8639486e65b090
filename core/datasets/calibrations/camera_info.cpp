// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/calibrations/camera_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/datasets/calibrations/readers.h"
#include "core/errors/error_text.h"
#include "core/files/dataset_error.h"

namespace plslam {
namespace {

/// Focal lengths and rows of a rectified pair differ at most by the rounding in the file.
constexpr double kSameProjection_px = 0.1;

/// Model and coefficients in plslam's convention.
void SetLens(const RosCameraInfo& info, CameraCalibration& camera) {
  const std::vector<double>& d = info.distortion;
  if (std::all_of(d.begin(), d.end(), [](double x) { return x == 0.0; })) return;  // a pinhole
  const bool is_fisheye = info.model == "equidistant" || info.model == "fisheye";
  const bool is_radtan = (info.model == "plumb_bob" || info.model.empty()) && (d.size() == 4 || d.size() == 5);
  const bool is_rational = info.model == "rational_polynomial" && d.size() >= 4;
  if (is_fisheye && d.size() == 4) {
    camera.model = lens_model::kEquidistant;
    camera.distortion = d;
    return;
  }
  if (!is_radtan && !is_rational) {
    throw DatasetError(
        fmt::format("distortion_model '{}' with {} coefficients is not one of plumb_bob (4 or 5), "
                    "rational_polynomial (8) and equidistant (4), so the images must be rectified",
                    Shown(info.model), d.size()));
  }
  const std::string complaint = SetOpenCvDistortion(d, &camera);
  if (!complaint.empty()) throw DatasetError("D of camera_info " + complaint);
}

CameraCalibration UncheckedCamera(const RosCameraInfo& info, bool rectified) {
  CameraCalibration camera;
  camera.width_px = info.width_px;
  camera.height_px = info.height_px;
  const Eigen::Matrix3d K = rectified ? Eigen::Matrix3d(info.P.leftCols<3>()) : info.K;
  if (std::abs(K(0, 1)) > kNoSkew_px) {
    throw DatasetError(fmt::format("K[1] of camera_info = {}: skew is not supported", K(0, 1)));
  }
  camera.fx_px = K(0, 0);
  camera.fy_px = K(1, 1);
  camera.cx_px = K(0, 2);
  camera.cy_px = K(1, 2);
  if (!rectified) SetLens(info, camera);
  return camera;
}

bool IsRotation(const Eigen::Matrix3d& R) {
  return R.allFinite() && (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3 && R.determinant() > 0.0;
}

/// P = K [I | t] with the same focal lengths and cy in both (cx may differ; of cameras one above the other cx is the
/// same and cy may differ). Some drivers and exporters write K [R | t] of the raw right camera instead.
void RequireRectifiedPair(const RosCameraInfo& left, const RosCameraInfo& right) {
  constexpr const char* kRemedy =
      "so P does not belong to a rectified pair (K [R | t] of the raw camera?): calibrate the pair, or give K, D, R "
      "and "
      "T as in OpenCV (docs/datasets.md)";
  const auto is = [](double value, double expected) { return std::abs(value - expected) <= 1e-6; };
  for (const RosCameraInfo* info : {&left, &right}) {
    const char* side = info == &left ? "left" : "right";
    const Eigen::Matrix<double, 3, 4>& P = info->P;
    constexpr int kZeros[][2] = {{0, 1}, {1, 0}, {2, 0}, {2, 1}};
    for (const auto& [row, column] : kZeros) {
      if (is(P(row, column), 0.0)) continue;
      throw DatasetError(fmt::format("P[{}] of the {} camera_info = {} is not 0, {}", 4 * row + column, side,
                                     P(row, column), kRemedy));
    }
    if (!is(P(2, 2), 1.0)) {
      throw DatasetError(fmt::format("P[10] of the {} camera_info = {} is not 1, {}", side, P(2, 2), kRemedy));
    }
  }
  const Eigen::Vector3d offset = right.P.col(3) - left.P.col(3);
  const bool are_beside = std::abs(offset.x()) >= std::abs(offset.y());
  const int shared[][2] = {{0, 0}, {1, 1}, {are_beside ? 1 : 0, 2}};
  for (const auto& [row, column] : shared) {
    const double l = left.P(row, column), r = right.P(row, column);
    if (std::abs(l - r) <= kSameProjection_px) continue;
    throw DatasetError(fmt::format("P[{}] of camera_info is {} on the left and {} on the right, {}", 4 * row + column,
                                   l, r, kRemedy));
  }
}

/// Drivers without a calibration file publish zeros.
void RequireCalibrated(const RosCameraInfo& info, const char* side, bool rectified) {
  const char* zeros = info.P.isZero(0.0) ? "P" : !rectified && info.K.isZero(0.0) ? "K" : nullptr;
  if (zeros == nullptr) return;
  throw DatasetError(
      fmt::format("{} of the {} camera_info is all 0, so that the camera is not calibrated, or not as one of "
                  "a pair: its driver had no calibration file",
                  zeros, side));
}

/// P[3] is -fx b for the right camera of a pair, and 0 for the left one.
void RequireSignOfBaseline(const RosCameraInfo& left, const RosCameraInfo& right) {
  const Eigen::Vector3d offset = right.P.col(3) - left.P.col(3);
  if (std::abs(offset.x()) < std::abs(offset.y()) || !(offset.x() > 0.0)) return;
  throw DatasetError(
      fmt::format("P[3] of camera_info is {} on the left and {} on the right, where it is 0 and -fx b (below 0): "
                  "left and right are "
                  "exchanged, or it has the wrong sign",
                  left.P(0, 3), right.P(0, 3)));
}

/// Returns the position of a camera in the rectified frame of the pair, in which P = K [I | t].
Eigen::Vector3d PlaceInRectified(const RosCameraInfo& info) {
  const Eigen::Matrix<double, 3, 4>& P = info.P;
  const double z = P(2, 3);
  return -Eigen::Vector3d((P(0, 3) - P(0, 2) * z) / P(0, 0), (P(1, 3) - P(1, 2) * z) / P(1, 1), z);
}

}  // namespace

bool NamesRectified(std::string_view topic) {
  constexpr std::string_view kBegin = "image_rect";
  topic = topic.substr(0, topic.find('#'));  // the type of a message, in channels of LCM
  while (!topic.empty()) {
    const std::string_view part = topic.substr(0, topic.find('/'));
    topic.remove_prefix(std::min(topic.size(), part.size() + 1));
    if (part == "rect" || part == "rectified" || part == kBegin || part == "image_rectified") return true;
    if (part.starts_with(kBegin) && part[kBegin.size()] == '_') return true;
  }
  return false;
}

void WarnOfUnusedDistortion(const std::string& topic, const RosCameraInfo& info, const std::string& remedy,
                            Notes* notes) {
  const std::vector<double>& d = info.distortion;
  if (!NamesRectified(topic) || std::all_of(d.begin(), d.end(), [](double k) { return k == 0.0; })) return;
  notes->Warn(
      fmt::format("D of the camera_info of {} is not 0, and is not applied, since the images of a topic of that "
                  "name are rectified; if they are not, {}",
                  topic, remedy));
}

ImageSize DeliveredSize(const RosCameraInfo& info) {
  const bool is_part = info.roi.width_px > 0 && info.roi.height_px > 0;
  return {(is_part ? info.roi.width_px : info.width_px) / std::max(info.binning_x, 1),
          (is_part ? info.roi.height_px : info.height_px) / std::max(info.binning_y, 1)};
}

RosCameraInfo InPixelsOfImages(RosCameraInfo info, const ImageSize& images) {
  const RosCameraInfo::Roi& roi = info.roi;
  if (roi.x_px < 0 || roi.y_px < 0 || int64_t{roi.x_px} + roi.width_px > info.width_px ||
      int64_t{roi.y_px} + roi.height_px > info.height_px || info.binning_x < 0 || info.binning_y < 0) {
    throw DatasetError(
        fmt::format("the region of interest of camera_info ({} x {} pixels at {}, {}; binning {} x {}) "
                    "is not within its {} x {} pixels",
                    roi.width_px, roi.height_px, roi.x_px, roi.y_px, info.binning_x, info.binning_y, info.width_px,
                    info.height_px));
  }
  const ImageSize whole{info.width_px, info.height_px}, delivered = DeliveredSize(info);
  const ImageSize size = images == ImageSize{} ? delivered : images;
  if (size != whole && size != delivered) {
    const std::string part = whole == delivered ? ""
                                                : fmt::format(" ({} x {} with its binning and region of interest)",
                                                              delivered.width_px, delivered.height_px);
    throw DatasetError(fmt::format("camera_info is for {} x {} pixels{}, but the images have {} x {}", whole.width_px,
                                   whole.height_px, part, size.width_px, size.height_px));
  }
  if (size == delivered && size != whole) {
    const Eigen::Vector2d shift(roi.x_px, roi.y_px);
    info.K.col(2).head<2>() -= shift;
    info.P.col(2).head<2>() -= shift;
    const Eigen::Vector2d pixels(std::max(info.binning_x, 1), std::max(info.binning_y, 1));
    for (int row = 0; row < 2; ++row) {
      info.K.row(row) /= pixels[row];
      info.P.row(row) /= pixels[row];
    }
  }
  info.width_px = size.width_px;
  info.height_px = size.height_px;
  info.binning_x = info.binning_y = 1;
  info.roi = {};
  return info;
}

CameraCalibration CameraFromRos(const RosCameraInfo& info, bool rectified) {
  if (rectified ? info.P.isZero(0.0) : info.K.isZero(0.0)) {
    throw DatasetError(fmt::format(
        "{} of camera_info is all 0, so that the camera is not calibrated: its driver had no calibration file",
        rectified ? "P" : "K"));
  }
  return UncheckedCamera(info, rectified);
}

RigCalibration RigFromRos(const RosCameraInfo& left, const RosCameraInfo& right, bool rectified) {
  RequireCalibrated(left, "left", rectified);
  RequireCalibrated(right, "right", rectified);
  RigCalibration rig;
  rig.left = UncheckedCamera(left, rectified);
  rig.right = UncheckedCamera(right, rectified);
  const Eigen::Vector3d offset = left.P.col(3) - right.P.col(3);
  if (!offset.allFinite() || offset.isZero(0.0)) {
    throw DatasetError(
        "camera_info has no baseline (P[3] of the right camera is -fx b): the cameras were calibrated separately, "
        "not as a pair");
  }
  RequireRectifiedPair(left, right);
  RequireSignOfBaseline(left, right);
  const Eigen::Vector3d right_m = PlaceInRectified(right) - PlaceInRectified(left);
  if (!rectified && (!IsRotation(left.R) || !IsRotation(right.R)))
    throw DatasetError("R of camera_info is not a rotation");
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d R_left = rectified ? I : left.R, R_right = rectified ? I : right.R;
  const SE3 T_l_r(Eigen::Matrix3d(R_left.transpose() * R_right), Eigen::Vector3d(R_left.transpose() * right_m));
  rig.right.T_b_cam = T_l_r;
  rig.baseline_m = T_l_r.translation().norm();
  return rig;
}

}  // namespace plslam
