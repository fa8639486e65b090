// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/io/png_kinds.h"

#include <fmt/format.h>
#include <png.h>

#include <random>
#include <stdexcept>

namespace plslam::test {
namespace {

[[noreturn]] void ThrowPngError(png_structp /*png*/, png_const_charp what) { throw std::runtime_error(what); }

void AppendToString(png_structp png, png_bytep bytes, size_t n) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), n);
}

void SetPalette(png_structp png, png_infop info, const PngKind& kind, std::mt19937& random) {
  const int n = 1 << kind.bits;
  std::vector<png_color> palette(static_cast<size_t>(n));
  const auto any = [&] { return static_cast<png_byte>(random() & 255U); };
  for (png_color& colour : palette) colour = {any(), any(), any()};
  png_set_PLTE(png, info, palette.data(), n);
  std::vector<png_byte> alpha(static_cast<size_t>(n) / 2);
  for (png_byte& a : alpha) a = any();
  if (kind.transparent_colour) png_set_tRNS(png, info, alpha.data(), n / 2, nullptr);
}

void SetRest(png_structp png, png_infop info, const PngKind& kind, std::mt19937& random) {
  png_color_16 key{0, 3, 2, 1, 1};
  if (kind.colour_type == PNG_COLOR_TYPE_PALETTE) {
    SetPalette(png, info, kind, random);
  } else if (kind.transparent_colour) {
    png_set_tRNS(png, info, nullptr, 0, &key);
  }
  if (!kind.gamma) return;
  png_set_gAMA(png, info, 1.0 / 1.8);
  png_set_cHRM(png, info, 0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06);
  std::string word = "Comment";
  std::string text(300, 'x');
  png_text comment{};
  comment.compression = PNG_TEXT_COMPRESSION_zTXt;
  comment.key = word.data();
  comment.text = text.data();
  comment.text_length = text.size();
  png_set_text(png, info, &comment, 1);
}

}  // namespace

std::string PngKind::Name() const {
  return fmt::format("colour type {}, {} bits, {} x {}{}{}{}", colour_type, bits, width_px, height_px,
                     interlaced ? ", interlaced" : "", transparent_colour ? ", with a transparent colour" : "",
                     gamma ? ", with gamma" : "");
}

std::vector<PngKind> AllPngKinds() {
  const std::vector<std::pair<int, std::vector<int>>> depths = {{PNG_COLOR_TYPE_GRAY, {1, 2, 4, 8, 16}},
                                                                {PNG_COLOR_TYPE_RGB, {8, 16}},
                                                                {PNG_COLOR_TYPE_PALETTE, {1, 2, 4, 8}},
                                                                {PNG_COLOR_TYPE_GRAY_ALPHA, {8, 16}},
                                                                {PNG_COLOR_TYPE_RGB_ALPHA, {8, 16}}};
  std::vector<PngKind> kinds;
  for (const auto& [type, bits] : depths) {
    for (const int b : bits) {
      for (int rest = 0; rest < 16; ++rest) {
        const bool key = (rest & 2) != 0;
        if (key && (type & PNG_COLOR_MASK_ALPHA) != 0) continue;
        const bool tiny = (rest & 8) != 0;
        kinds.push_back({type, b, (rest & 1) != 0, key, (rest & 4) != 0, tiny ? 1 : 37, tiny ? 3 : 23});
      }
    }
  }
  return kinds;
}

std::string MakePng(const PngKind& kind, unsigned seed) {
  std::mt19937 random(seed);
  std::string file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, ThrowPngError, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &file, AppendToString, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(kind.width_px), static_cast<png_uint_32>(kind.height_px),
               kind.bits, kind.colour_type, kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  SetRest(png, info, kind, random);
  png_write_info(png, info);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_ALL_FILTERS);
  const size_t row_bytes = png_get_rowbytes(png, info);
  std::vector<png_byte> pixels(row_bytes * static_cast<size_t>(kind.height_px));
  for (png_byte& byte : pixels) byte = static_cast<png_byte>(random() & 255U);
  std::vector<png_bytep> rows;
  for (int y = 0; y < kind.height_px; ++y) rows.push_back(pixels.data() + static_cast<size_t>(y) * row_bytes);
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

}  // namespace plslam::test
