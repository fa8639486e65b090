// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/png_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <png.h>
#include <zlib.h>

#include "core/files/atomic_file.h"
#include "core/files/bytes.h"
#include "core/io/images/png_grey.h"

namespace plslam {
namespace {

using PngReason = std::array<char, 128>;

[[noreturn]] void GiveUpPng(png_structp png, png_const_charp why) {
  auto& reason = *static_cast<PngReason*>(png_get_error_ptr(png));
  std::snprintf(reason.data(), reason.size(), "%s", why);
  png_longjmp(png, 1);
}

void PassOverPngWarning(png_structp /*png*/, png_const_charp /*what*/) {}

/// Returns whether `steps` completed. An error of libpng leaves it by longjmp, past stack frames that must have no
/// destructors: its own, and those of `steps`.
template <class Steps>
bool RunPngSteps(png_structp png, const Steps& steps) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  steps();
  return true;
}

/// The two structures of libpng for one direction, freed at the end of the scope.
template <auto kCreate, auto kDestroy>
class PngHandle {
 public:
  PngHandle()
      : png_(kCreate(PNG_LIBPNG_VER_STRING, &reason_, GiveUpPng, PassOverPngWarning)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {
    if (info_ == nullptr) {
      kDestroy(&png_, &info_);
      throw std::runtime_error("libpng cannot be initialised");
    }
  }
  ~PngHandle() { kDestroy(&png_, &info_); }
  PngHandle(const PngHandle&) = delete;
  PngHandle& operator=(const PngHandle&) = delete;

  template <class Steps>
  void Run(const Steps& steps) {
    if (!RunPngSteps(png_, steps)) throw std::runtime_error(reason_.data());
  }
  png_structp png() const { return png_; }
  png_infop info() const { return info_; }

 private:
  PngReason reason_{};
  png_structp png_;
  png_infop info_;
};

void DestroyPngReader(png_structpp png, png_infopp info) { png_destroy_read_struct(png, info, nullptr); }

using PngReader = PngHandle<png_create_read_struct, DestroyPngReader>;
using PngWriter = PngHandle<png_create_write_struct, png_destroy_write_struct>;

void TakePngBytes(png_structp png, png_bytep out, size_t n) {
  auto& rest = *static_cast<std::span<const uint8_t>*>(png_get_io_ptr(png));
  if (n > rest.size()) png_error(png, "it is truncated");
  std::memcpy(out, rest.data(), n);
  rest = rest.subspan(n);
}

void GivePngBytes(png_structp png, png_bytep bytes, size_t n) {
  if (!AppendBytes(*static_cast<std::string*>(png_get_io_ptr(png)), bytes, n)) png_error(png, "out of memory");
}

void FlushNothingOfPng(png_structp /*png*/) {}

/// Requests the pixel format that `DecodePng` documents; returns the number of channels.
int AskForPngPixels(png_structp png, png_infop info) {
  const int kind = png_get_color_type(png, info);
  const bool coloured = (kind & PNG_COLOR_MASK_COLOR) != 0;
  const bool keyed = coloured && png_get_valid(png, info, PNG_INFO_tRNS) != 0;
  const bool transparent = (kind & PNG_COLOR_MASK_ALPHA) != 0 || keyed;
  if (std::endian::native == std::endian::little) png_set_swap(png);
  if (kind == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (!coloured && png_get_bit_depth(png, info) < 8) png_set_expand_gray_1_2_4_to_8(png);
  if (keyed) png_set_tRNS_to_alpha(png);
  if (coloured) png_set_bgr(png);
  if (!coloured && transparent) png_set_gray_to_rgb(png);
  return transparent ? 4 : coloured ? 3 : 1;
}

void SetPngEffort(png_structp png, std::optional<int> compression) {
  if (compression) {
    png_set_compression_level(png, std::clamp(*compression, 0, 9));
    png_set_compression_strategy(png, Z_DEFAULT_STRATEGY);
  } else {
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_level(png, Z_BEST_SPEED);
    png_set_compression_strategy(png, Z_RLE);
  }
}

int PngKindOf(const cv::Mat& image) {
  const bool depth_fits = image.depth() == CV_8U || image.depth() == CV_16U;
  if (!image.empty() && image.dims == 2 && depth_fits) {
    if (image.channels() == 1) return PNG_COLOR_TYPE_GRAY;
    if (image.channels() == 3) return PNG_COLOR_TYPE_RGB;
    if (image.channels() == 4) return PNG_COLOR_TYPE_RGB_ALPHA;
  }
  throw std::invalid_argument("a PNG file needs at least one pixel, of 8 or 16 bits in 1, 3 or 4 channels");
}

}  // namespace

cv::Mat DecodePng(std::span<const uint8_t> bytes, cv::Size size) {
  if (std::optional<cv::Mat> grey = DecodeGreyPng(bytes, size)) return *std::move(grey);
  PngReader reader;
  png_structp const png = reader.png();
  png_infop const info = reader.info();
  int channels = 0;
  int n_passes = 0;
  reader.Run([&] {
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_set_read_fn(png, &bytes, TakePngBytes);
    png_read_info(png, info);
    channels = AskForPngPixels(png, info);
    n_passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
  });
  cv::Mat image(size, CV_MAKETYPE(png_get_bit_depth(png, info) == 16 ? CV_16U : CV_8U, channels));
  if (png_get_image_width(png, info) != static_cast<png_uint_32>(size.width) ||
      png_get_image_height(png, info) != static_cast<png_uint_32>(size.height) ||
      png_get_rowbytes(png, info) != static_cast<size_t>(image.cols) * image.elemSize()) {
    throw std::runtime_error("its pixels contradict its header");
  }
  uint8_t* const pixels = image.data;
  const size_t step = image.step[0];
  reader.Run([&] {
    for (int pass = 0; pass < n_passes; ++pass) {
      for (int y = 0; y < size.height; ++y) png_read_row(png, pixels + static_cast<size_t>(y) * step, nullptr);
    }
    png_read_end(png, nullptr);
  });
  return image;
}

std::string EncodePng(const cv::Mat& image, std::optional<int> compression) {
  const int kind = PngKindOf(image);
  std::string file;
  PngWriter writer;
  png_structp const png = writer.png();
  png_infop const info = writer.info();
  const uint8_t* const pixels = image.data;
  const size_t step = image.step[0];
  const int n_rows = image.rows;
  writer.Run([&] {
    png_set_write_fn(png, &file, GivePngBytes, FlushNothingOfPng);
    SetPngEffort(png, compression);
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.cols), static_cast<png_uint_32>(n_rows),
                 image.depth() == CV_16U ? 16 : 8, kind, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    if (kind != PNG_COLOR_TYPE_GRAY) png_set_bgr(png);
    if (std::endian::native == std::endian::little) png_set_swap(png);
    for (int y = 0; y < n_rows; ++y) png_write_row(png, pixels + static_cast<size_t>(y) * step);
    png_write_end(png, info);
  });
  return file;
}

void WritePng(const std::string& path, const cv::Mat& image, std::optional<int> compression) {
  WriteFileAtomically(path, EncodePng(image, compression));
}

}  // namespace plslam
