// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/image_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/errors/error_text.h"
#include "core/files/dataset_error.h"
#include "core/files/git_lfs.h"
#include "core/io/images/image_header.h"
#include "core/io/images/jpeg_codec.h"
#include "core/io/images/png_codec.h"

namespace plslam {
namespace {

constexpr int64_t kMaxFileBytes = 512LL * 1024 * 1024;
// Enough for a JPEG whose frame header follows colour profiles and thumbnails.
constexpr int64_t kMaxHeaderBytes = 1024LL * 1024;

[[noreturn]] void Fail(const std::string& path, const std::string& what) { throw DatasetError(path + ": " + what); }

std::vector<uint8_t> ReadBytes(const std::string& path, int64_t limit) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) Fail(path, "the image is missing");
  const std::string why = WhyUnreadable(path);
  if (!why.empty()) Fail(path, "the image " + why);
  if (!std::filesystem::is_regular_file(status)) Fail(path, "is not a file");
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) Fail(path, "the image cannot be opened: " + ReasonOf(errno));
  const auto size = static_cast<int64_t>(file.tellg());
  if (size > kMaxFileBytes) Fail(path, fmt::format("has {} bytes, more than {}", size, kMaxFileBytes));
  std::vector<uint8_t> bytes = AsDatasetError([&] {
    return WithMemoryFor(fmt::format("{}: {} bytes", path, size), [&] {
      return std::vector<uint8_t>(static_cast<size_t>(std::clamp<int64_t>(size, 0, limit)));
    });
  });
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) Fail(path, fmt::format("the image cannot be read to its end: {}", ReasonOf(errno)));
  if (bytes.empty()) Fail(path, "the image is empty (0 bytes)");
  return bytes;
}

/// Formats that are met under the names of those that can be read.
struct OtherFormat {
  std::string_view start;
  const char* name;
};
constexpr std::array<OtherFormat, 8> kOtherFormats = {{{{"II*\0", 4}, "TIFF"},
                                                       {{"MM\0*", 4}, "TIFF"},
                                                       {"BM", "BMP"},
                                                       {"GIF8", "GIF"},
                                                       {"RIFF", "WebP or AVI"},
                                                       {"P2", "PGM of text"},
                                                       {"P6", "colour PPM"},
                                                       {"<", "page of HTML or XML, perhaps of a failed download"}}};

std::string WhyNoHeader(std::span<const uint8_t> bytes) {
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()), std::min<size_t>(bytes.size(), 64));
  if (IsGitLfsPointer(start)) return kGitLfsPointer;
  for (const char* known : {"\x89PNG", "\xff\xd8", "P5"}) {
    if (start.starts_with(known)) {
      return fmt::format("begins like an image, but its header is damaged or truncated ({} bytes)", bytes.size());
    }
  }
  std::string found = fmt::format("it begins with '{}'", Shown(start.substr(0, 8)));
  for (const OtherFormat& other : kOtherFormats) {
    if (start.starts_with(other.start)) found = fmt::format("it seems to be a {}", other.name);
  }
  return "is not a PNG, JPEG or binary PGM image: " + found;
}

ImageHeader CheckedHeader(const std::string& path, std::span<const uint8_t> bytes) {
  const std::optional<ImageHeader> header = ParseImageHeader(bytes);
  if (!header) Fail(path, WhyNoHeader(bytes));
  if (header->width_px < 1 || header->height_px < 1 || header->width_px > kMaxImagePixels ||
      header->height_px > kMaxImagePixels || header->width_px * header->height_px > kMaxImagePixels) {
    Fail(path, fmt::format("has {} x {} pixels according to its header, which is zero or more than {} (8192 x 8192)",
                           header->width_px, header->height_px, kMaxImagePixels));
  }
  return *header;
}

cv::Mat DecodePgm(const ImageHeader& header, std::span<const uint8_t> bytes) {
  const bool wide = header.max_value > 255;
  cv::Mat image(static_cast<int>(header.height_px), static_cast<int>(header.width_px), wide ? CV_16UC1 : CV_8UC1);
  const uint8_t* in = bytes.data() + header.data_offset;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (wide) {
        image.at<uint16_t>(y, x) = static_cast<uint16_t>(in[0] << 8 | in[1]);
      } else {
        image.at<uint8_t>(y, x) = in[0];
      }
      in += wide ? 2 : 1;
    }
  }
  return image;
}

cv::Mat DecodeImage(const std::string& path, const ImageHeader& header, std::span<const uint8_t> bytes) {
  const cv::Size size(static_cast<int>(header.width_px), static_cast<int>(header.height_px));
  try {
    switch (header.format) {
      case ImageFormat::kPng:
        return DecodePng(bytes, size);
      case ImageFormat::kJpeg:
        return DecodeJpeg(bytes, size);
      case ImageFormat::kPgm:
        return DecodePgm(header, bytes);
    }
  } catch (const std::exception& e) {
    if (IsOfMemory(e)) Fail(path, fmt::format("{} x {} pixels: {}", size.width, size.height, SentenceOf(e)));
    Fail(path, fmt::format("the image is damaged and cannot be decoded: {}", e.what()));
  }
  Fail(path, "is not in a known format");
}

// Grey values of a PGM may end at any number; black to white is the whole range of the pixels here.
void StretchToWhite(int max_value, cv::Mat& image) {
  const int white = image.depth() == CV_16U ? 65535 : 255;
  if (max_value < white) image.convertTo(image, -1, static_cast<double>(white) / max_value);
}

/// With the header it was decoded by.
struct DecodedImage {
  ImageHeader header;
  cv::Mat pixels;
};

DecodedImage DecodeWhole(const std::string& path, std::span<const uint8_t> bytes, const ImageSize& expected) {
  const ImageHeader header = CheckedHeader(path, bytes);
  if (header.width_px != expected.width_px || header.height_px != expected.height_px) {
    Fail(path, fmt::format("has {} x {} pixels instead of {} x {}", header.width_px, header.height_px,
                           expected.width_px, expected.height_px));
  }
  if (!IsComplete(header, bytes)) Fail(path, fmt::format("the image is truncated after {} bytes", bytes.size()));
  return {header, DecodeImage(path, header, bytes)};
}

DecodedImage ReadImage(const std::string& path, const ImageSize& expected) {
  return DecodeWhole(path, ReadBytes(path, kMaxFileBytes), expected);
}

/// round(255 v / white) in integers, at most 255. `clipped`, if given, becomes the part of the pixels above.
cv::Mat To8Bit(const cv::Mat& wide, int white, double* clipped) {
  std::vector<uint8_t> narrow_of(kWhiteOf16Bits + 1);
  for (int v = 0; v <= kWhiteOf16Bits; ++v) {
    narrow_of[static_cast<size_t>(v)] = static_cast<uint8_t>((std::min(v, white) * 255 + white / 2) / white);
  }
  cv::Mat narrow(wide.size(), CV_8UC1);
  for (int y = 0; y < wide.rows; ++y) {
    const auto* in = wide.ptr<uint16_t>(y);
    auto* out = narrow.ptr<uint8_t>(y);
    for (int x = 0; x < wide.cols; ++x) out[x] = narrow_of[in[x]];
  }
  if (clipped != nullptr && white < kWhiteOf16Bits) {
    *clipped = static_cast<double>(cv::countNonZero(wide > white)) / static_cast<double>(wide.total());
  }
  return narrow;
}

/// Returns pixels of 8 or 16 bits with one, three or four channels.
cv::Mat CheckedPixels(const std::string& path, const DecodedImage& decoded) {
  cv::Mat image = decoded.pixels;
  if (decoded.header.format == ImageFormat::kPgm) StretchToWhite(decoded.header.max_value, image);
  if (image.depth() != CV_8U && image.depth() != CV_16U) Fail(path, "has neither 8-bit nor 16-bit pixels");
  if (image.channels() != 1 && image.channels() != 3 && image.channels() != 4) {
    Fail(path, fmt::format("has {} channels", image.channels()));
  }
  return image;
}

cv::Mat GreyOf(const std::string& path, const DecodedImage& decoded, std::optional<int> white, double* clipped) {
  const cv::Mat image = CheckedPixels(path, decoded);
  return GreyPixels(image, white ? *white : WhiteLevel(BrightWideValue(image)), clipped);
}

}  // namespace

ImageSize ReadImageSize(const std::string& path) {
  const ImageHeader header = CheckedHeader(path, ReadBytes(path, kMaxHeaderBytes));
  return {static_cast<int>(header.width_px), static_cast<int>(header.height_px)};
}

int WhiteLevel(int bright) {
  if (bright <= 1) return kWhiteOf16Bits;
  int white = 255;
  while (white < std::min(bright, kWhiteOf16Bits)) white = 4 * white + 3;
  return white;
}

int BrightWideValue(const cv::Mat& image) {
  if (image.depth() != CV_16U) return 0;
  const cv::Mat values = image.reshape(1);
  std::vector<int> n_of(kWhiteOf16Bits + 1);
  for (int y = 0; y < values.rows; ++y) {
    const auto* row = values.ptr<uint16_t>(y);
    for (int x = 0; x < values.cols; ++x) ++n_of[row[x]];
  }
  auto n_brighter = static_cast<int64_t>(kHotPixels * static_cast<double>(values.total()));
  int bright = kWhiteOf16Bits;
  while (bright > 1 && n_of[static_cast<size_t>(bright)] <= n_brighter) {
    n_brighter -= n_of[static_cast<size_t>(bright--)];
  }
  return bright;
}

int BrightWideValue(const std::string& name, std::span<const uint8_t> file, const ImageSize& expected) {
  if (CheckedHeader(name, file).bits <= 8) return 0;
  return BrightWideValue(CheckedPixels(name, DecodeWhole(name, file, expected)));
}

int BrightWideValue(const std::string& path, const ImageSize& expected) {
  if (CheckedHeader(path, ReadBytes(path, kMaxHeaderBytes)).bits <= 8) return 0;
  return BrightWideValue(path, ReadBytes(path, kMaxFileBytes), expected);
}

cv::Mat GreyPixels(const cv::Mat& image, int white, double* clipped) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (image.channels() == 4) cv::cvtColor(image, grey, cv::COLOR_BGRA2GRAY);
  return grey.depth() == CV_16U ? To8Bit(grey, white, clipped) : grey;
}

cv::Mat ReadGreyImage(const std::string& path, const ImageSize& expected, std::optional<int> white, double* clipped) {
  return GreyOf(path, ReadImage(path, expected), white, clipped);
}

cv::Mat DecodeGreyImage(const std::string& name, std::span<const uint8_t> file, const ImageSize& expected,
                        std::optional<int> white, double* clipped) {
  return GreyOf(name, DecodeWhole(name, file, expected), white, clipped);
}

cv::Mat ReadGreyImage(const std::string& path) { return ReadGreyImage(path, ReadImageSize(path)); }

cv::Mat ReadDepthImage(const std::string& path, const ImageSize& expected) {
  cv::Mat image = ReadImage(path, expected).pixels;
  if (image.type() != CV_16UC1) {
    Fail(path, fmt::format("a depth map has one channel of 16 bits, but this image has {} of {}", image.channels(),
                           8 * image.elemSize1()));
  }
  return image;
}

}  // namespace plslam
