// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/pixel_encodings.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/errors/error_text.h"
#include "core/io/images/image_file.h"

namespace plslam {
namespace {

/// How pixels become grey, or BGR.
enum class Conversion { kNone, kRgb, kFirstOfTwo, kSecondOfTwo, kRggb, kGrbg, kBggr, kGbrg };

/// An encoding of raw images, as sensor_msgs names them.
struct Encoding {
  std::string_view name;
  int type;
  Conversion conversion = Conversion::kNone;
  /// Rows of the data for two rows of the image: colours of planar YUV are below the luma.
  int rows_for_two = 2;
};
constexpr auto kEncodings = std::to_array<Encoding>({{"mono8", CV_8UC1},
                                                     {"8UC1", CV_8UC1},
                                                     {"mono16", CV_16UC1},
                                                     {"16UC1", CV_16UC1},
                                                     {"bgr8", CV_8UC3},
                                                     {"8UC3", CV_8UC3},
                                                     {"rgb8", CV_8UC3, Conversion::kRgb},
                                                     {"bgra8", CV_8UC4},
                                                     {"8UC4", CV_8UC4},
                                                     {"rgba8", CV_8UC4, Conversion::kRgb},
                                                     {"bgr16", CV_16UC3},
                                                     {"16UC3", CV_16UC3},
                                                     {"rgb16", CV_16UC3, Conversion::kRgb},
                                                     {"bgra16", CV_16UC4},
                                                     {"16UC4", CV_16UC4},
                                                     {"rgba16", CV_16UC4, Conversion::kRgb},
                                                     {"bayer_rggb8", CV_8UC1, Conversion::kRggb},
                                                     {"bayer_grbg8", CV_8UC1, Conversion::kGrbg},
                                                     {"bayer_bggr8", CV_8UC1, Conversion::kBggr},
                                                     {"bayer_gbrg8", CV_8UC1, Conversion::kGbrg},
                                                     {"bayer_rggb16", CV_16UC1, Conversion::kRggb},
                                                     {"bayer_grbg16", CV_16UC1, Conversion::kGrbg},
                                                     {"bayer_bggr16", CV_16UC1, Conversion::kBggr},
                                                     {"bayer_gbrg16", CV_16UC1, Conversion::kGbrg},
                                                     {"yuv422_yuy2", CV_8UC2, Conversion::kFirstOfTwo},
                                                     {"yuyv", CV_8UC2, Conversion::kFirstOfTwo},
                                                     {"yuv422", CV_8UC2, Conversion::kSecondOfTwo},
                                                     {"uyvy", CV_8UC2, Conversion::kSecondOfTwo},
                                                     {"nv12", CV_8UC1, Conversion::kNone, 3},
                                                     {"nv21", CV_8UC1, Conversion::kNone, 3},
                                                     {"i420", CV_8UC1, Conversion::kNone, 3},
                                                     {"yv12", CV_8UC1, Conversion::kNone, 3},
                                                     {"yuv420", CV_8UC1, Conversion::kNone, 3},
                                                     {"nv16", CV_8UC1, Conversion::kNone, 4},
                                                     {"nv24", CV_8UC1, Conversion::kNone, 6}});

const Encoding* FindEncoding(const std::string& name) {
  const auto* const found = std::find_if(kEncodings.begin(), kEncodings.end(),
                                         [&](const Encoding& encoding) { return encoding.name == name; });
  return found == kEncodings.end() ? nullptr : found;
}

const Encoding& EncodingOf(const std::string& name) {
  const Encoding* const encoding = FindEncoding(name);
  if (encoding == nullptr) throw DatasetError(PixelEncodingComplaint(name));
  return *encoding;
}

void SwapBytes(cv::Mat& pixels) {
  const size_t n = pixels.elemSize1();
  for (int y = 0; y < pixels.rows; ++y) {
    auto* row = pixels.ptr(y);
    for (size_t i = 0; i + n <= static_cast<size_t>(pixels.cols) * pixels.elemSize(); i += n) {
      std::reverse(row + i, row + i + n);
    }
  }
}

/// `rows_for_two`: rows of the data for two rows of the image.
cv::Mat WithoutPadding(const RosPixels& image, const cv::Size& expected, int type, int rows_for_two) {
  const int64_t row_bytes = int64_t{expected.width} * CV_ELEM_SIZE(type);
  const int64_t step_bytes = image.step_bytes != 0 ? image.step_bytes : row_bytes;
  const int64_t n_rows = int64_t{expected.height} * rows_for_two / 2;
  const auto n_bytes = static_cast<int64_t>(image.data.size());
  if (expected.empty() || step_bytes < row_bytes || step_bytes > n_bytes ||
      n_bytes < step_bytes * (n_rows - 1) + row_bytes) {
    throw DatasetError(fmt::format("has {} bytes in rows of {} for {} x {} pixels of {}", n_bytes, step_bytes,
                                   image.width_px, image.height_px, Shown(image.encoding)));
  }
  cv::Mat pixels(expected, type);
  for (int y = 0; y < expected.height; ++y) {
    std::copy_n(image.data.data() + step_bytes * y, row_bytes, pixels.ptr(y));
  }
  if (image.is_big_endian && pixels.elemSize1() > 1) SwapBytes(pixels);
  return pixels;
}

/// The pixels as they are, without padding.
cv::Mat PixelsOf(const RosPixels& image, const Encoding& encoding, const cv::Size& expected) {
  if (image.width_px != expected.width || image.height_px != expected.height) {
    throw DatasetError(fmt::format("has {} x {} pixels instead of {} x {}", image.width_px, image.height_px,
                                   expected.width, expected.height));
  }
  return WithoutPadding(image, expected, encoding.type, encoding.rows_for_two);
}

cv::Mat Converted(const cv::Mat& pixels, Conversion conversion) {
  cv::Mat converted;  // a separate image: demosaicing cannot work in place
  const auto convert = [&](int code) { cv::cvtColor(pixels, converted, code); };
  switch (conversion) {
    case Conversion::kNone:
      return pixels;
    case Conversion::kRgb:
      convert(pixels.channels() == 3 ? cv::COLOR_RGB2BGR : cv::COLOR_RGBA2BGRA);
      break;
    case Conversion::kFirstOfTwo:
      cv::extractChannel(pixels, converted, 0);
      break;
    case Conversion::kSecondOfTwo:
      cv::extractChannel(pixels, converted, 1);
      break;
    case Conversion::kRggb:
      convert(cv::COLOR_BayerRGGB2GRAY);
      break;
    case Conversion::kGrbg:
      convert(cv::COLOR_BayerGRBG2GRAY);
      break;
    case Conversion::kBggr:
      convert(cv::COLOR_BayerBGGR2GRAY);
      break;
    case Conversion::kGbrg:
      convert(cv::COLOR_BayerGBRG2GRAY);
      break;
  }
  return converted;
}

}  // namespace

std::string PixelEncodingComplaint(const std::string& encoding) {
  if (FindEncoding(encoding) != nullptr) return "";
  return fmt::format(
      "its images are encoded as '{}', not as mono, bgr, rgb, bgra, rgba or bayer of 8 or 16 bits, or as YUV (yuyv, "
      "uyvy, nv12, nv21, nv16, nv24, i420): convert them (image_proc, cv_bridge)",
      Shown(encoding));
}

cv::Mat GreyOfRosPixels(const RosPixels& image, const cv::Size& expected, int white, double* clipped) {
  const Encoding& encoding = EncodingOf(image.encoding);
  return GreyPixels(Converted(PixelsOf(image, encoding, expected), encoding.conversion), white, clipped);
}

cv::Mat PixelsAsTheyAre(const RosPixels& image, const cv::Size& size, int type) {
  return WithoutPadding(image, size, type, 2);
}

int BrightWideValue(const RosPixels& image, const cv::Size& expected) {
  const Encoding& encoding = EncodingOf(image.encoding);
  if (CV_MAT_DEPTH(encoding.type) != CV_16U) return 0;
  return BrightWideValue(PixelsOf(image, encoding, expected));
}

}  // namespace plslam
