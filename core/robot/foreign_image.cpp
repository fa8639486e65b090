// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/foreign_image.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "core/datasets/recordings/depth_images.h"
#include "core/datasets/recordings/pixel_encodings.h"
#include "core/files/dataset_error.h"
#include "core/io/images/image_file.h"

namespace plslam::robot {
namespace {

constexpr int32_t FourCharacters(const char (&text)[5]) {
  return text[0] | text[1] << 8 | text[2] << 16 | text[3] << 24;
}

struct PixelFormat {
  int32_t number;
  std::string_view encoding;
};
constexpr auto kPixelFormats = std::to_array<PixelFormat>({{FourCharacters("GREY"), "mono8"},
                                                           {FourCharacters("LG16"), "mono16"},
                                                           {FourCharacters("RGB3"), "rgb8"},
                                                           {FourCharacters("BGR3"), "bgr8"},
                                                           {FourCharacters("RGB4"), "rgba8"},
                                                           {FourCharacters("BGR4"), "bgra8"},
                                                           {FourCharacters("RGBL"), "rgb16"},
                                                           {FourCharacters("YUYV"), "yuyv"},
                                                           {FourCharacters("UYVY"), "uyvy"},
                                                           {FourCharacters("NV12"), "nv12"},
                                                           {FourCharacters("I420"), "i420"},
                                                           {FourCharacters("YU12"), "i420"},
                                                           {FourCharacters("BA81"), "bayer_bggr8"},
                                                           {FourCharacters("XXX2"), "bayer_gbrg8"},
                                                           {FourCharacters("XXX3"), "bayer_grbg8"},
                                                           {FourCharacters("XXX4"), "bayer_rggb8"},
                                                           {FourCharacters("LBA1"), "bayer_bggr16"},
                                                           {FourCharacters("LBA2"), "bayer_gbrg16"},
                                                           {FourCharacters("LBA3"), "bayer_grbg16"},
                                                           {FourCharacters("LBA4"), "bayer_rggb16"},
                                                           {FourCharacters("MJPG"), ""}});

/// As the messages of ROS describe pixels.
RosPixels PixelsOf(const ForeignImage& image) {
  return {.width_px = image.width_px,
          .height_px = image.height_px,
          .step_bytes = image.step_bytes,
          .encoding = image.encoding,
          .is_big_endian = image.is_big_endian,
          .data = image.bytes};
}

}  // namespace

std::string EncodingOfPixelFormat(int32_t pixelformat) {
  for (const PixelFormat& format : kPixelFormats) {
    if (format.number == pixelformat) return std::string(format.encoding);
  }
  throw DatasetError(fmt::format(
      "its pixelformat {} is not one of grey, Bayer, RGB, BGR, RGBA, BGRA, YUYV, UYVY, NV12, I420 or JPEG",
      pixelformat));
}

cv::Mat GreyOf(const ForeignImage& image, const cv::Size& expected, int white) {
  if (!image.encoding.empty()) return GreyOfRosPixels(PixelsOf(image), expected, white);
  return DecodeGreyImage("the file in it", image.bytes, {expected.width, expected.height}, white);
}

cv::Mat DepthsOf(const ForeignImage& image, const cv::Size& expected, double units_per_m) {
  if (!image.encoding.empty()) return DepthsOfRosPixels(PixelsOf(image), expected, units_per_m);
  return DepthsOfCompressed(image.format, image.bytes, expected, units_per_m);
}

int BrightWideValue(const ForeignImage& image, const cv::Size& expected) {
  if (!image.encoding.empty()) return plslam::BrightWideValue(PixelsOf(image), expected);
  return plslam::BrightWideValue("the file in it", image.bytes, {expected.width, expected.height});
}

}  // namespace plslam::robot
