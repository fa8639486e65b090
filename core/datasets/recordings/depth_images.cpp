// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/depth_images.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "core/errors/error_text.h"
#include "core/io/images/image_header.h"
#include "core/io/images/png_codec.h"

namespace plslam {
namespace {

constexpr std::string_view kMetres = "32FC1";
constexpr const char* kRegistered = "depth maps must be registered to the colour image, pixel by pixel";

uint16_t Units(double depth_m, double units_per_m) {
  const double units = std::round(depth_m * units_per_m);
  return units >= 1.0 && units <= std::numeric_limits<uint16_t>::max() ? static_cast<uint16_t>(units) : 0;
}

cv::Mat DecodeDepthPng(std::span<const uint8_t> file, const cv::Size& expected) {
  const std::optional<ImageHeader> header = ParseImageHeader(file);
  if (!header || header->format != ImageFormat::kPng) throw DatasetError("has no PNG file of depths in it");
  if (header->width_px != expected.width || header->height_px != expected.height) {
    throw DatasetError(fmt::format("has {} x {} pixels instead of {} x {}: {}", header->width_px, header->height_px,
                                   expected.width, expected.height, kRegistered));
  }
  cv::Mat depths = AsDatasetError([&] { return DecodePng(file, expected); });
  if (depths.type() != CV_16UC1) throw DatasetError("has a PNG file of 8 bits or of colours, not of 16-bit depths");
  return depths;
}

/// In front of the PNG file of compressed_depth_image_transport: an unused number, and a and b of the inverse depth
/// q = a / depth + b, which the file has if depths are in metres.
struct InverseDepth {
  float a = 0.0F;
  float b = 0.0F;
};
constexpr size_t kConfigBytes = 12;

}  // namespace

std::string DepthEncodingComplaint(const std::string& encoding) {
  if (encoding == "16UC1" || encoding == "mono16" || encoding == kMetres) return "";
  return fmt::format("its images are encoded as '{}', not as depths (16UC1, mono16 or 32FC1)", Shown(encoding));
}

cv::Mat DepthsOfRosPixels(const RosPixels& image, const cv::Size& expected, double units_per_m) {
  const std::string complaint = DepthEncodingComplaint(image.encoding);
  if (!complaint.empty()) throw DatasetError(complaint);
  if (image.width_px != expected.width || image.height_px != expected.height) {
    throw DatasetError(fmt::format("has {} x {} pixels instead of {} x {}: {}", image.width_px, image.height_px,
                                   expected.width, expected.height, kRegistered));
  }
  const bool is_float = image.encoding == kMetres;
  cv::Mat pixels = PixelsAsTheyAre(image, expected, is_float ? CV_32FC1 : CV_16UC1);
  if (!is_float) return pixels;
  cv::Mat depths(expected, CV_16UC1);
  for (int y = 0; y < depths.rows; ++y) {
    for (int x = 0; x < depths.cols; ++x) {
      depths.at<uint16_t>(y, x) = Units(static_cast<double>(pixels.at<float>(y, x)), units_per_m);
    }
  }
  return depths;
}

cv::Mat DepthsOfCompressed(const std::string& format, std::span<const uint8_t> bytes, const cv::Size& expected,
                           double units_per_m) {
  if (format.find("compressedDepth") == std::string::npos) return DecodeDepthPng(bytes, expected);
  if (format.find("rvl") != std::string::npos) {
    throw DatasetError("is compressed by RVL; set the parameter format of compressedDepth to png");
  }
  if (bytes.size() < kConfigBytes) throw DatasetError("the message ends before its last field");
  InverseDepth inverse;
  std::memcpy(&inverse, bytes.data() + kConfigBytes - sizeof(inverse), sizeof(inverse));
  cv::Mat depths = DecodeDepthPng(bytes.subspan(kConfigBytes), expected);
  if (!format.starts_with(kMetres)) return depths;
  for (int y = 0; y < depths.rows; ++y) {
    for (int x = 0; x < depths.cols; ++x) {
      auto& depth = depths.at<uint16_t>(y, x);
      if (depth != 0)
        depth = Units(static_cast<double>(inverse.a / (static_cast<float>(depth) - inverse.b)), units_per_m);
    }
  }
  return depths;
}

}  // namespace plslam
