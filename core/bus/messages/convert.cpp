// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/convert.h"

#include "core/bus/messages/imu_channel.h"
#include "core/bus/transport/wire.h"
#include "core/geometry/distortion.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "plslam/camera_t.hpp"
#include "plslam/intrinsics_t.hpp"
#include "plslam/line_feature_t.hpp"
#include "plslam/mask_t.hpp"
#include "plslam/point_feature_t.hpp"
#include "plslam/polygon_t.hpp"
#include "plslam/pose3_t.hpp"
#include "plslam/rectified_camera_t.hpp"

namespace plslam::bus {
namespace {

constexpr int kMaxSide_px = 32'768;
constexpr double kMaxPixel = 1e6;

bool Finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool PixelsOk(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::abs(v) <= kMaxPixel; });
}

float ToFloat(double value) { return static_cast<float>(value); }

polygon_t ToPolygon(const MaskPolygon& polygon) {
  polygon_t message{};
  message.in_use = polygon.in_use ? 1 : 0;
  message.n_corners = static_cast<int32_t>(polygon.corners_px.size());
  for (const Eigen::Vector2f& px : polygon.corners_px) message.corners_px.push_back({px.x(), px.y()});
  return message;
}

/// Returns nullopt if there are more corners than a camera may have, or one is far outside any image.
std::optional<std::vector<MaskPolygon>> FromPolygons(const std::vector<polygon_t>& messages) {
  std::vector<MaskPolygon> polygons;
  size_t n_corners = 0;
  for (const polygon_t& message : messages) {
    n_corners += message.corners_px.size();
    if (n_corners > kMaxMaskCorners) return std::nullopt;
    MaskPolygon polygon;
    polygon.in_use = message.in_use != 0;
    for (const std::vector<float>& px : message.corners_px) {
      if (!(std::abs(px[0]) <= 2.0 * kMaxSide_px && std::abs(px[1]) <= 2.0 * kMaxSide_px)) return std::nullopt;
      polygon.corners_px.emplace_back(px[0], px[1]);
    }
    polygons.push_back(std::move(polygon));
  }
  return polygons;
}

// Follows the model of a camera with a rolling shutter; the readout in milliseconds follows it. The layout of the
// message is that of logs of earlier versions.
constexpr std::string_view kRolling = " rolling ";
// Kinds of rigs.
constexpr const char* kStereo = "stereo";
constexpr const char* kRgbd = "rgbd";
// Follows the kind of a rig with an inertial sensor, for the same reason; its calibration follows it.
constexpr std::string_view kWithImu = " imu ";

std::string RollingText(double readout_ms) {
  if (readout_ms == 0.0) return "";
  std::array<char, 32> digits{};
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), readout_ms);
  return std::string(kRolling).append(digits.data(), result.ptr);
}

/// Splits the name of the model from the readout; nullopt for a number that is none.
std::optional<std::pair<std::string, double>> SplitModel(const std::string& text) {
  const size_t at = text.find(kRolling);
  if (at == std::string::npos) return std::pair(text, 0.0);
  const char* begin = text.data() + at + kRolling.size();
  const char* end = text.data() + text.size();
  double readout_ms = 0.0;
  const auto [last, error] = std::from_chars(begin, end, readout_ms);
  if (error != std::errc() || last != end || !(readout_ms > 0.0 && readout_ms <= kMaxReadout_ms)) return std::nullopt;
  return std::pair(text.substr(0, at), readout_ms);
}

intrinsics_t ToIntrinsics(const CameraCalibration& camera) {
  intrinsics_t message{};
  message.width_px = camera.width_px;
  message.height_px = camera.height_px;
  message.model = camera.model + RollingText(camera.readout_ms);
  message.fx_px = camera.fx_px;
  message.fy_px = camera.fy_px;
  message.cx_px = camera.cx_px;
  message.cy_px = camera.cy_px;
  message.n_distortion = static_cast<int32_t>(camera.distortion.size());
  message.distortion = camera.distortion;
  message.T_b_cam = ToMessage(camera.T_b_cam);
  message.n_mask = static_cast<int32_t>(camera.mask.size());
  for (const MaskPolygon& polygon : camera.mask) message.mask.push_back(ToPolygon(polygon));
  return message;
}

std::optional<CameraCalibration> FromIntrinsics(const intrinsics_t& message) {
  const auto T_b_cam = FromMessage(message.T_b_cam);
  const bool size_ok = message.width_px > 0 && message.height_px > 0 && message.width_px <= kMaxSide_px &&
                       message.height_px <= kMaxSide_px;
  const auto model = SplitModel(message.model);
  const bool lens_ok =
      model && PositiveFinite({message.fx_px, message.fy_px}) && Finite({message.cx_px, message.cy_px}) &&
      LensModelTakes(model->first, message.distortion.size()) &&
      std::all_of(message.distortion.begin(), message.distortion.end(), [](double k) { return std::isfinite(k); });
  auto mask = FromPolygons(message.mask);
  if (!T_b_cam || !size_ok || !lens_ok || !mask) return std::nullopt;
  CameraCalibration camera;
  camera.width_px = message.width_px;
  camera.height_px = message.height_px;
  camera.model = model->first;
  camera.readout_ms = model->second;
  camera.fx_px = message.fx_px;
  camera.fy_px = message.fy_px;
  camera.cx_px = message.cx_px;
  camera.cy_px = message.cy_px;
  camera.distortion = message.distortion;
  camera.T_b_cam = *T_b_cam;
  camera.mask = *std::move(mask);
  return camera;
}

}  // namespace

bool PositiveFinite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v) && v > 0.0; });
}

pose3_t ToMessage(const SE3& T_a_b) {
  pose3_t message{};
  const Eigen::Quaterniond& q = T_a_b.rotation();
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double q_wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  for (int i = 0; i < 4; ++i) message.q_wxyz[i] = sign * q_wxyz[i];
  for (int i = 0; i < 3; ++i) message.position_m[i] = T_a_b.translation()[i];
  return message;
}

std::optional<SE3> FromMessage(const pose3_t& message) {
  const Eigen::Quaterniond q(message.q_wxyz[0], message.q_wxyz[1], message.q_wxyz[2], message.q_wxyz[3]);
  const Eigen::Vector3d t(message.position_m[0], message.position_m[1], message.position_m[2]);
  const double error = std::abs(q.squaredNorm() - 1.0);
  if (!t.allFinite() || !(error < 2e-6)) return std::nullopt;  // NaN too
  // Normalised again, a quaternion may change its last bits, and the copy of a map would not be the map.
  return error < 1e-12 ? SE3::FromUnit(q, t) : SE3(q, t);
}

void ToArray(const Matrix6d& covariance, double (&values)[36]) {
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> rows(&values[0]);
  rows = covariance;
}

std::optional<Matrix6d> FromArray(const double (&values)[36]) {
  const Matrix6d covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(&values[0]);
  if (!covariance.allFinite() || covariance.diagonal().minCoeff() < 0.0) return std::nullopt;
  const double scale = covariance.cwiseAbs().maxCoeff();
  const double asymmetry = (covariance - covariance.transpose()).cwiseAbs().maxCoeff();
  return asymmetry <= 1e-6 * scale ? std::optional(covariance) : std::nullopt;
}

void ToArray(const std::optional<UpDirection>& up, double (&up_c)[3], double& sigma_rad) {
  for (int i = 0; i < 3; ++i) up_c[i] = up ? up->direction[i] : 0.0;
  sigma_rad = up ? up->sigma_rad : 0.0;
}

bool FromArray(const double (&up_c)[3], double sigma_rad, std::optional<UpDirection>& up) {
  const Eigen::Vector3d direction(up_c[0], up_c[1], up_c[2]);
  up.reset();
  if (sigma_rad == 0.0 && direction.isZero(0.0)) return true;
  const UpDirection received{direction, sigma_rad};
  const bool is_ok = received.IsValid();
  if (is_ok) up = received;
  return is_ok;
}

void ToBytes(const Descriptor& descriptor, uint8_t (&bytes)[32]) {
  for (size_t i = 0; i < 32; ++i) bytes[i] = static_cast<uint8_t>(descriptor[i / 8] >> (8 * (i % 8)));
}

Descriptor FromBytes(const uint8_t (&bytes)[32]) {
  Descriptor descriptor{};
  for (size_t i = 0; i < 32; ++i) descriptor[i / 8] |= uint64_t{bytes[i]} << (8 * (i % 8));
  return descriptor;
}

camera_t ToMessage(const RigCalibration& rig) {
  camera_t message{};
  message.rig_name = rig.name;
  message.kind = rig.kind == RigCalibration::Kind::kRgbd ? kRgbd : kStereo;
  if (rig.imu) message.kind.append(kWithImu).append(ImuText(*rig.imu));
  message.rate_hz = rig.rate_hz;
  message.left = ToIntrinsics(rig.left);
  message.right = ToIntrinsics(rig.right);
  message.depth_units_per_m = rig.depth_units_per_m;
  message.baseline_m = rig.baseline_m;
  return message;
}

std::optional<RigCalibration> FromMessage(const camera_t& message) {
  const auto left = FromIntrinsics(message.left);
  const auto right = FromIntrinsics(message.right);
  const size_t kind_end = std::min(message.kind.find(kWithImu), message.kind.size());
  const std::string kind = message.kind.substr(0, kind_end);
  const bool rgbd = kind == kRgbd;
  if (!left || !right || (!rgbd && kind != kStereo)) return std::nullopt;
  std::optional<ImuCalibration> imu;
  if (kind_end < message.kind.size()) {
    imu = ImuFromText(std::string_view(message.kind).substr(kind_end + kWithImu.size()));
    if (!imu) return std::nullopt;
  }
  const bool numbers_ok = std::isfinite(message.rate_hz) && message.rate_hz >= 0.0 &&
                          PositiveFinite({message.baseline_m}) && std::isfinite(message.depth_units_per_m) &&
                          (rgbd ? message.depth_units_per_m > 0.0 : message.depth_units_per_m >= 0.0);
  if (!numbers_ok) return std::nullopt;
  RigCalibration rig;
  rig.name = message.rig_name;
  rig.kind = rgbd ? RigCalibration::Kind::kRgbd : RigCalibration::Kind::kStereo;
  rig.rate_hz = message.rate_hz;
  rig.left = *left;
  rig.right = *right;
  rig.depth_units_per_m = message.depth_units_per_m;
  rig.baseline_m = message.baseline_m;
  rig.imu = imu;
  return rig;
}

point_feature_t ToMessage(const StereoPoint& point, TrackId landmark_id, LandmarkId map_id) {
  point_feature_t message{};
  message.landmark_id = landmark_id.value;
  message.map_id = map_id.value;
  message.u_px = ToFloat(point.left.px.x());
  message.v_px = ToFloat(point.left.px.y());
  message.disparity_px = ToFloat(point.HasDepth() ? point.disparity_px : -1.0);
  message.sigma_px = ToFloat(point.sigma_px);
  message.sigma_disparity_px = ToFloat(point.sigma_disparity_px);
  message.angle_rad = point.left.angle_rad;
  message.octave = static_cast<int8_t>(point.left.octave);
  ToBytes(point.left.descriptor, message.descriptor);
  return message;
}

std::optional<StereoPoint> FromMessage(const point_feature_t& message) {
  const bool ok = PixelsOk({message.u_px, message.v_px, message.disparity_px}) && std::isfinite(message.angle_rad) &&
                  PositiveFinite({message.sigma_px, message.sigma_disparity_px}) && message.octave >= 0 &&
                  message.octave <= kMaxOctave && message.landmark_id >= -1 && message.map_id >= -1;
  if (!ok) return std::nullopt;
  StereoPoint point;
  point.left.px = {message.u_px, message.v_px};
  point.left.angle_rad = message.angle_rad;
  point.left.octave = static_cast<uint8_t>(message.octave);
  point.left.descriptor = FromBytes(message.descriptor);
  point.disparity_px = message.disparity_px > 0.0F ? message.disparity_px : -1.0;
  point.sigma_px = message.sigma_px;
  point.sigma_disparity_px = message.sigma_disparity_px;
  return point;
}

line_feature_t ToMessage(const StereoLine& line, TrackId landmark_id, LandmarkId map_id) {
  line_feature_t message{};
  message.landmark_id = landmark_id.value;
  message.map_id = map_id.value;
  for (int i = 0; i < 2; ++i) {
    message.p_px[i] = ToFloat(line.left.segment.p[i]);
    message.q_px[i] = ToFloat(line.left.segment.q[i]);
  }
  message.has_depth = line.HasDepth() ? 1 : 0;
  message.disparity_p_px = ToFloat(line.HasDepth() ? line.disparity_p_px : -1.0);
  message.disparity_q_px = ToFloat(line.HasDepth() ? line.disparity_q_px : -1.0);
  message.sigma_px = ToFloat(line.sigma_px);
  message.sigma_disparity_p_px = ToFloat(line.sigma_disparity_p_px);
  message.sigma_disparity_q_px = ToFloat(line.sigma_disparity_q_px);
  message.octave = static_cast<int8_t>(line.left.octave);
  ToBytes(line.left.descriptor, message.descriptor);
  return message;
}

std::optional<StereoLine> FromMessage(const line_feature_t& message) {
  const bool pixels_ok = PixelsOk({message.p_px[0], message.p_px[1], message.q_px[0], message.q_px[1],
                                   message.disparity_p_px, message.disparity_q_px});
  const bool rest_ok =
      PositiveFinite({message.sigma_px, message.sigma_disparity_p_px, message.sigma_disparity_q_px}) &&
      message.octave >= 0 && message.octave <= kMaxOctave && message.landmark_id >= -1 && message.map_id >= -1;
  if (!pixels_ok || !rest_ok) return std::nullopt;
  StereoLine line;
  line.left.segment.p = {message.p_px[0], message.p_px[1]};
  line.left.segment.q = {message.q_px[0], message.q_px[1]};
  line.left.octave = static_cast<uint8_t>(message.octave);
  line.left.descriptor = FromBytes(message.descriptor);
  const bool has_depth = message.has_depth != 0 && message.disparity_p_px > 0.0F && message.disparity_q_px > 0.0F;
  line.disparity_p_px = has_depth ? message.disparity_p_px : -1.0;
  line.disparity_q_px = has_depth ? message.disparity_q_px : -1.0;
  line.sigma_px = message.sigma_px;
  line.sigma_disparity_p_px = message.sigma_disparity_p_px;
  line.sigma_disparity_q_px = message.sigma_disparity_q_px;
  return line;
}

rectified_camera_t ToMessage(const StereoCamera& camera) {
  rectified_camera_t message{};
  message.f_px = camera.f_px;
  message.cx_px = camera.cx_px;
  message.cy_px = camera.cy_px;
  message.baseline_m = camera.baseline_m;
  message.left_px = camera.left_px;
  message.top_px = camera.top_px;
  message.width_px = camera.width_px;
  message.height_px = camera.height_px;
  message.taken_f_px = camera.taken_f_px;
  return message;
}

std::optional<StereoCamera> FromMessage(const rectified_camera_t& message) {
  constexpr int32_t kMost_px = 1'000'000;
  const auto is_place = [](int32_t px) { return px >= -kMost_px && px <= kMost_px; };
  const auto is_size = [](int32_t px) { return px >= 1 && px <= kMost_px; };
  const bool ok = message.f_px >= 1.0 && PositiveFinite({message.baseline_m}) && message.taken_f_px >= 0.0 &&
                  PixelsOk({message.f_px, message.cx_px, message.cy_px, message.taken_f_px}) &&
                  is_place(message.left_px) && is_place(message.top_px) && is_size(message.width_px) &&
                  is_size(message.height_px);
  if (!ok) return std::nullopt;
  return StereoCamera{message.f_px,      message.cx_px,   message.cy_px,  message.baseline_m, message.width_px,
                      message.height_px, message.left_px, message.top_px, message.taken_f_px};
}

mask_t ToMessage(const FrameMask& mask) {
  mask_t message{};
  for (const MaskPolygon& polygon : mask.left) message.left.push_back(ToPolygon(polygon));
  for (const MaskPolygon& polygon : mask.right) message.right.push_back(ToPolygon(polygon));
  message.n_left = static_cast<int32_t>(message.left.size());
  message.n_right = static_cast<int32_t>(message.right.size());
  return message;
}

std::optional<FrameMask> FromMessage(const mask_t& message) {
  auto left = FromPolygons(message.left);
  auto right = FromPolygons(message.right);
  if (!left || !right) return std::nullopt;
  return FrameMask{*std::move(left), *std::move(right)};
}

std::vector<uint8_t> RigBytes(camera_t message) {
  message.header = {};
  return Encoded(message);
}

}  // namespace plslam::bus
