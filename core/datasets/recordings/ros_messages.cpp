// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/ros_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/recordings/depth_images.h"
#include "core/datasets/recordings/pixel_encodings.h"
#include "core/errors/error_text.h"
#include "core/io/images/image_header.h"

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

/// Reads a CompressedImage after its header: the name of its file in errors, and the file.
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
  // Larger values are rejected later with all other numbers of the rig.
  info.height_px = static_cast<int>(std::min<uint32_t>(height, 1U << 30));
  info.width_px = static_cast<int>(std::min<uint32_t>(width, 1U << 30));
  info.model = reader.Text();
  const auto n = reader.Get<uint32_t>();
  constexpr uint32_t kMostCoefficients = 64;
  if (n > kMostCoefficients) throw DatasetError(fmt::format("has {} distortion coefficients", n));
  for (uint32_t i = 0; i < n; ++i) info.distortion.push_back(reader.Get<double>());
  info.K = GetRows<Eigen::Matrix3d>(reader);
  info.R = GetRows<Eigen::Matrix3d>(reader);
  info.P = GetRows<Eigen::Matrix<double, 3, 4>>(reader);
  const auto get_px = [&reader] { return static_cast<int>(std::min<uint32_t>(reader.Get<uint32_t>(), 1U << 30)); };
  info.binning_x = get_px();
  info.binning_y = get_px();
  info.roi.x_px = get_px();
  info.roi.y_px = get_px();
  info.roi.height_px = get_px();
  info.roi.width_px = get_px();
  return info;
}

std::string ImageEncoding(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding) {
  if (type != kRosImage) return "";
  RosReader reader(message, encoding);
  reader.SkipHeader();
  return PixelsOf(reader).encoding;
}

cv::Mat ParseImage(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                   const cv::Size& expected, int white, double* clipped) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  if (type == kRosImage) return GreyOfRosPixels(PixelsOf(reader), expected, white, clipped);
  const auto [name, file] = FileOf(reader);
  return DecodeGreyImage(name, file, {expected.width, expected.height}, white, clipped);
}

cv::Mat ParseDepths(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                    const cv::Size& expected, double units_per_m) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  if (type == kRosImage) return DepthsOfRosPixels(PixelsOf(reader), expected, units_per_m);
  const std::string format = reader.Text();
  return DepthsOfCompressed(format, reader.Bytes(), expected, units_per_m);
}

int BrightWideValue(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                    const cv::Size& expected) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  if (type == kRosImage) return BrightWideValue(PixelsOf(reader), expected);
  const auto [name, file] = FileOf(reader);
  return BrightWideValue(name, file, {expected.width, expected.height});
}

ImageSize SizeOfImage(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  if (type == kRosImage) {
    const int64_t height_px = reader.Get<uint32_t>(), width_px = reader.Get<uint32_t>();
    if (std::max(height_px, width_px) > kMaxImagePixels) return {};
    return {static_cast<int>(width_px), static_cast<int>(height_px)};
  }
  reader.Text();  // format
  const std::optional<ImageHeader> header = ParseImageHeader(reader.Bytes());
  if (!header || std::max(header->width_px, header->height_px) > kMaxImagePixels) return {};
  return {static_cast<int>(header->width_px), static_cast<int>(header->height_px)};
}

namespace {

/// Frames of ROS 1 may begin with a slash.
std::string FrameName(std::string name) { return name.starts_with('/') ? name.substr(1) : name; }

Eigen::Vector3d GetVector(RosReader& reader) {
  const auto x = reader.Get<double>(), y = reader.Get<double>(), z = reader.Get<double>();
  return {x, y, z};
}

Eigen::Quaterniond GetQuaternion(RosReader& reader) {
  const auto x = reader.Get<double>(), y = reader.Get<double>(), z = reader.Get<double>(), w = reader.Get<double>();
  return {w, x, y, z};
}

constexpr double kUnitTolerance = 1e-2;

}  // namespace

RosImu ParseImu(std::span<const uint8_t> message, RosEncoding encoding) {
  constexpr double kNotMeasured = -1.0;
  RosReader reader(message, encoding);
  RosReader::Header header = reader.ReadHeader();
  RosImu imu;
  imu.frame = FrameName(std::move(header.frame));
  imu.sample.t_ns = header.t_ns;
  GetQuaternion(reader);
  GetRows<Eigen::Matrix3d>(reader);
  imu.sample.rate_rad_s = GetVector(reader);
  imu.has_rate = GetRows<Eigen::Matrix3d>(reader)(0, 0) != kNotMeasured;
  imu.sample.force_m_s2 = GetVector(reader);
  imu.has_force = GetRows<Eigen::Matrix3d>(reader)(0, 0) != kNotMeasured;
  if (!imu.sample.rate_rad_s.allFinite() || !imu.sample.force_m_s2.allFinite()) {
    throw DatasetError("has numbers that are not finite");
  }
  return imu;
}

void ParseTransforms(std::span<const uint8_t> message, RosEncoding encoding, StaticFrames* frames) {
  RosReader reader(message, encoding);
  std::string complaint;
  for (auto n = reader.Get<uint32_t>(); n > 0; --n) {
    const std::string parent = FrameName(reader.ReadHeader().frame);
    const std::string child = FrameName(reader.Text());
    const Eigen::Vector3d t = GetVector(reader);
    const Eigen::Quaterniond q = GetQuaternion(reader);
    if (!t.allFinite() || !(std::abs(q.norm() - 1.0) < kUnitTolerance)) {
      complaint = fmt::format("has an invalid transform of {}", Shown(child));
    } else {
      frames->Add(parent, child, SE3(q, t));
    }
  }
  if (!complaint.empty()) throw DatasetError(complaint);
}

std::string FrameOf(std::span<const uint8_t> message, RosEncoding encoding) {
  return FrameName(RosReader(message, encoding).ReadHeader().frame);
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
    throw DatasetError("a pose is invalid: not finite, or its quaternion has not unit length");
  return {q, pose.translation()};
}

}  // namespace plslam
