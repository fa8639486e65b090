// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/foreign_image.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "core/datasets/recordings/ros_messages.h"
#include "core/io/files/dataset_error.h"
#include "core/io/images/image_file.h"

namespace plslam::adapter {
namespace {

constexpr int32_t FourCharacters(const char (&text)[5]) {
  return text[0] | text[1] << 8 | text[2] << 16 | text[3] << 24;
}

struct PixelFormat {
  int32_t number;
  std::string_view encoding;
};
constexpr auto kPixelFormats = std::to_array<PixelFormat>({{FourCharacters("GREY"), "mono8"},
                                                           {FourCharacters("RGB3"), "rgb8"},
                                                           {FourCharacters("BGR3"), "bgr8"},
                                                           {FourCharacters("RGB4"), "rgba8"},
                                                           {FourCharacters("BGR4"), "bgra8"},
                                                           {FourCharacters("MJPG"), ""}});

}  // namespace

std::string EncodingOfPixelFormat(int32_t pixelformat) {
  for (const PixelFormat& format : kPixelFormats) {
    if (format.number == pixelformat) return std::string(format.encoding);
  }
  throw DatasetError(fmt::format("its pixelformat {} is none of grey, RGB, BGR, RGBA, BGRA and JPEG", pixelformat));
}

cv::Mat GreyOf(const ForeignImage& image, const cv::Size& expected) {
  if (image.encoding.empty()) {
    return DecodeGreyImage("the file in it", image.bytes, {expected.width, expected.height});
  }
  return GreyOfRosPixels({.width_px = image.width_px,
                          .height_px = image.height_px,
                          .step_bytes = image.step_bytes,
                          .encoding = image.encoding,
                          .is_big_endian = image.is_big_endian,
                          .data = image.bytes},
                         expected);
}

}  // namespace plslam::adapter
