// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/ros_messages.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/errors/error_text.h"
#include "core/io/images/image_header.h"

namespace plslam {
namespace {

/// An encoding of raw images, as sensor_msgs names them.
struct Encoding {
  std::string_view name;
  int type;
  bool is_rgb;
};
constexpr auto kEncodings = std::to_array<Encoding>({{"mono8", CV_8UC1, false},
                                                     {"8UC1", CV_8UC1, false},
                                                     {"mono16", CV_16UC1, false},
                                                     {"16UC1", CV_16UC1, false},
                                                     {"bgr8", CV_8UC3, false},
                                                     {"8UC3", CV_8UC3, false},
                                                     {"rgb8", CV_8UC3, true},
                                                     {"bgra8", CV_8UC4, false},
                                                     {"rgba8", CV_8UC4, true}});

const Encoding& EncodingOf(const std::string& name) {
  for (const Encoding& encoding : kEncodings) {
    if (encoding.name == name) return encoding;
  }
  throw DatasetError(
      fmt::format("its images are encoded as '{}', not as mono8, mono16, bgr8, rgb8, bgra8 or rgba8", Shown(name)));
}

cv::Mat RawPixels(RosReader& reader, const cv::Size& expected) {
  RosPixels pixels;
  pixels.height_px = reader.Get<uint32_t>();
  pixels.width_px = reader.Get<uint32_t>();
  pixels.encoding = reader.Text();
  pixels.is_big_endian = reader.Get<uint8_t>() != 0;
  pixels.step_bytes = reader.Get<uint32_t>();
  pixels.data = reader.Bytes();
  return GreyOfRosPixels(pixels, expected);
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

cv::Mat GreyOfRosPixels(const RosPixels& image, const cv::Size& expected) {
  const Encoding& encoding = EncodingOf(image.encoding);
  if (image.width_px != expected.width || image.height_px != expected.height) {
    throw DatasetError(fmt::format("has {} x {} pixels where {} x {} are expected", image.width_px, image.height_px,
                                   expected.width, expected.height));
  }
  const int64_t row_bytes = int64_t{expected.width} * CV_ELEM_SIZE(encoding.type);
  const int64_t step_bytes = image.step_bytes != 0 ? image.step_bytes : row_bytes;
  const auto n_bytes = static_cast<int64_t>(image.data.size());
  if (expected.empty() || step_bytes < row_bytes || n_bytes < step_bytes * (expected.height - 1) + row_bytes) {
    throw DatasetError(fmt::format("has {} bytes in rows of {} for {} x {} pixels of {}", n_bytes, step_bytes,
                                   image.width_px, image.height_px, encoding.name));
  }
  if (image.is_big_endian && CV_MAT_DEPTH(encoding.type) == CV_16U) {
    throw DatasetError("its pixels of 16 bits are in the order of big-endian machines");
  }
  cv::Mat pixels(expected, encoding.type);
  for (int y = 0; y < expected.height; ++y) {
    std::copy_n(image.data.data() + step_bytes * y, row_bytes, pixels.ptr(y));
  }
  if (encoding.is_rgb) {
    cv::cvtColor(pixels, pixels, pixels.channels() == 3 ? cv::COLOR_RGB2BGR : cv::COLOR_RGBA2BGRA);
  }
  return GreyPixels(pixels);
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
  const auto get_px = [&reader] { return static_cast<int>(std::min<uint32_t>(reader.Get<uint32_t>(), 1U << 30)); };
  info.binning_x = get_px();
  info.binning_y = get_px();
  info.roi.x_px = get_px();
  info.roi.y_px = get_px();
  info.roi.height_px = get_px();
  info.roi.width_px = get_px();
  return info;
}

cv::Mat ParseImage(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                   const cv::Size& expected) {
  RosReader reader(message, encoding);
  reader.SkipHeader();
  if (type == kRosImage) return RawPixels(reader, expected);
  const std::string format = reader.Text();
  return DecodeGreyImage(fmt::format("'{}'", Shown(format)), reader.Bytes(), {expected.width, expected.height});
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

}  // namespace plslam
