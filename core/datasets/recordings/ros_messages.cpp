// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/ros_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/calibrations/readers.h"
#include "core/datasets/recordings/pixel_encodings.h"
#include "core/errors/error_text.h"
#include "core/io/images/image_file.h"

namespace plslam {
namespace {

RosPixels PixelsOf(RosReader& reader) {
  RosPixels pixels;
  pixels.height_px = reader.Get<uint32_t>();
  pixels.width_px = reader.Get<uint32_t>();
  pixels.encoding = reader.Text();
  pixels.is_big_endian = reader.Get<uint8_t>() != 0;
  pixels.step_bytes = reader.Get<uint32_t>();
  pixels.data = reader.Bytes();
  return pixels;
}

/// Of a CompressedImage behind its header: the name of its file in errors, and the file.
std::pair<std::string, std::span<const uint8_t>> FileOf(RosReader& reader) {
  const std::string name = fmt::format("'{}'", Shown(reader.Text()));
  return {name, reader.Bytes()};
}

template <class Matrix>
Matrix GetRows(RosReader& reader) {
  Matrix m;
  for (int row = 0; row < m.rows(); ++row) {
    for (int column = 0; column < m.cols(); ++column) m(row, column) = reader.Get<double>();
  }
  return m;
}

/// Model and coefficients in our names.
void SetLens(const RosCameraInfo& info, CameraCalibration& camera) {
  const std::vector<double>& d = info.distortion;
  if (std::all_of(d.begin(), d.end(), [](double x) { return x == 0.0; })) return;  // a pinhole
  const bool is_fisheye = info.model == "equidistant" || info.model == "fisheye";
  const bool is_radtan = info.model == "plumb_bob" && (d.size() == 4 || d.size() == 5);
  const bool is_rational = info.model == "rational_polynomial" && d.size() >= 5;
  if (is_fisheye && d.size() == 4) {
    camera.model = "equidistant";
    camera.distortion = d;
    return;
  }
  if (!is_radtan && !is_rational) {
    throw DatasetError(fmt::format(
        "distortion_model '{}' with {} coefficients is none of plumb_bob (4 or 5), rational_polynomial (8) "
        "and equidistant (4), so that the images would have to be rectified",
        Shown(info.model), d.size()));
  }
  const std::string complaint = SetOpenCvDistortion(d, &camera);
  if (!complaint.empty()) throw DatasetError("D of camera_info " + complaint);
}

CameraCalibration CameraFromRos(const RosCameraInfo& info, bool rectified) {
  CameraCalibration camera;
  camera.width_px = info.width_px;
  camera.height_px = info.height_px;
  const Eigen::Matrix3d K = rectified ? Eigen::Matrix3d(info.P.leftCols<3>()) : info.K;
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

}  // namespace

std::optional<RosEncoding> RosEncodingOf(std::string_view name) {
  if (name == "cdr") return RosEncoding::kCdr;
  if (name == "ros1") return RosEncoding::kRos1;
  return std::nullopt;
}

RosCameraInfo ParseCameraInfo(std::span<const uint8_t> message, RosEncoding encoding) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  RosCameraInfo info;
  const auto height = reader.Get<uint32_t>(), width = reader.Get<uint32_t>();
  // What is larger is refused with all other numbers of the rig.
  info.height_px = static_cast<int>(std::min<uint32_t>(height, 1U << 30));
  info.width_px = static_cast<int>(std::min<uint32_t>(width, 1U << 30));
  info.model = reader.Text();
  const auto n = reader.Get<uint32_t>();
  constexpr uint32_t kMostCoefficients = 64;
  if (n > kMostCoefficients) throw DatasetError(fmt::format("has {} coefficients of distortion", n));
  for (uint32_t i = 0; i < n; ++i) info.distortion.push_back(reader.Get<double>());
  info.K = GetRows<Eigen::Matrix3d>(reader);
  info.R = GetRows<Eigen::Matrix3d>(reader);
  info.P = GetRows<Eigen::Matrix<double, 3, 4>>(reader);
  return info;
}

std::string ImageEncoding(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding) {
  if (type != kRosImage) return "";
  RosReader reader(message, encoding);
  reader.SkipHeader();
  return PixelsOf(reader).encoding;
}

cv::Mat ParseImage(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                   const cv::Size& expected, int white) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  if (type == kRosImage) return GreyOfRosPixels(PixelsOf(reader), expected, white);
  const auto [name, file] = FileOf(reader);
  return DecodeGreyImage(name, file, {expected.width, expected.height}, white);
}

int LargestWideValue(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                     const cv::Size& expected) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  if (type == kRosImage) return LargestWideValue(PixelsOf(reader), expected);
  const auto [name, file] = FileOf(reader);
  return LargestWideValue(name, file, {expected.width, expected.height});
}

SE3 ParsePose(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  if (type == kRosOdometry) reader.Text();  // child_frame_id
  std::array<double, 7> v{};
  for (double& x : v) x = reader.Get<double>();
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  const SE3 pose = SE3::FromUnit(q, {v[0], v[1], v[2]});
  if (!pose.IsFinite() || std::abs(q.norm() - 1.0) > 1e-2)
    throw DatasetError("a pose is none: not finite, or not unit");
  return {q, pose.translation()};
}

RigCalibration RigFromRos(const RosCameraInfo& left, const RosCameraInfo& right, bool rectified) {
  RigCalibration rig;
  rig.left = CameraFromRos(left, rectified);
  rig.right = CameraFromRos(right, rectified);
  const double b = (left.P(0, 3) - right.P(0, 3)) / right.P(0, 0);
  if (!std::isfinite(b) || b == 0.0) {
    throw DatasetError("camera_info has no baseline (P[3] of the right camera is -fx b)");
  }
  if (!rectified && (!IsRotation(left.R) || !IsRotation(right.R)))
    throw DatasetError("R of camera_info is no rotation");
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const SE3 T_l_r = LeftFromRight(rectified ? I : left.R, rectified ? I : right.R, b);
  rig.right.T_b_cam = T_l_r;
  rig.baseline_m = T_l_r.translation().norm();
  return rig;
}

}  // namespace plslam
