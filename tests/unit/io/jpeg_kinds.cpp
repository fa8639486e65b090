// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/io/jpeg_kinds.h"

#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

#include <jpeglib.h>

namespace plslam::test {
namespace {

[[noreturn]] void ThrowJpegError(j_common_ptr jpeg) {
  char text[JMSG_LENGTH_MAX];
  jpeg->err->format_message(jpeg, text);
  throw std::runtime_error(text);
}

void Configure(jpeg_compress_struct& jpeg, const JpegKind& kind) {
  jpeg_set_defaults(&jpeg);
  jpeg_set_colorspace(&jpeg, static_cast<J_COLOR_SPACE>(kind.stored));
  jpeg_set_quality(&jpeg, kind.quality, TRUE);
  for (int i = 0; i < jpeg.num_components; ++i) {
    const bool luma = i == 0 || i == 3;
    jpeg.comp_info[i].h_samp_factor = luma && kind.sampling > 1 ? 2 : 1;
    jpeg.comp_info[i].v_samp_factor = luma && kind.sampling > 2 ? 2 : 1;
  }
  jpeg.restart_in_rows = kind.restart_rows;
  jpeg.arith_code = kind.arithmetic ? TRUE : FALSE;
  jpeg.optimize_coding = kind.optimised ? TRUE : FALSE;
  if (kind.progressive) jpeg_simple_progression(&jpeg);
}

void WriteOrientation(jpeg_compress_struct& jpeg, int orientation) {
  const unsigned char exif[] = {
      'E', 'x', 'i', 'f', 0,  0, 'M', 'M', 0, 42, 0, 0, 0,
      8,   0,   1,   1,   18, 0, 3,   0,   0, 0,  1, 0, static_cast<unsigned char>(orientation),
      0,   0,   0,   0,   0,  0};
  jpeg_write_marker(&jpeg, JPEG_APP0 + 1, exif, sizeof(exif));
}

/// Without its segments DHT.
std::string WithoutTables(const std::string& file) {
  std::string rest = file;
  for (size_t at = rest.find("\xff\xc4"); at != std::string::npos; at = rest.find("\xff\xc4")) {
    const auto byte = [&](size_t i) { return static_cast<size_t>(static_cast<unsigned char>(rest[i])); };
    rest.erase(at, 2 + (byte(at + 2) << 8) + byte(at + 3));
  }
  return rest;
}

}  // namespace

std::vector<JpegKind> AllJpegKinds() {
  return {
      {.name = "grey"},
      {.name = "grey, progressive", .progressive = true},
      {.name = "grey, without tables", .without_tables = true},
      {.name = "grey, turned", .orientation = 6},
      {.name = "grey, coarse", .quality = 5},
      {.name = "grey, arithmetic", .arithmetic = true},
      {.name = "colour 4:4:4", .pixels = JCS_RGB, .stored = JCS_YCbCr, .components = 3},
      {.name = "colour 4:2:2", .pixels = JCS_RGB, .stored = JCS_YCbCr, .components = 3, .sampling = 2},
      {.name = "colour 4:2:0", .pixels = JCS_RGB, .stored = JCS_YCbCr, .components = 3, .sampling = 4},
      {.name = "colour, progressive",
       .pixels = JCS_RGB,
       .stored = JCS_YCbCr,
       .components = 3,
       .sampling = 4,
       .progressive = true},
      {.name = "colour, restarts",
       .pixels = JCS_RGB,
       .stored = JCS_YCbCr,
       .components = 3,
       .sampling = 4,
       .optimised = true,
       .restart_rows = 1},
      {.name = "colour, without tables",
       .pixels = JCS_RGB,
       .stored = JCS_YCbCr,
       .components = 3,
       .sampling = 4,
       .without_tables = true},
      {.name = "colour, turned", .pixels = JCS_RGB, .stored = JCS_YCbCr, .components = 3, .orientation = 3},
      {.name = "RGB", .pixels = JCS_RGB, .stored = JCS_RGB, .components = 3},
      {.name = "CMYK", .pixels = JCS_CMYK, .stored = JCS_CMYK, .components = 4},
      {.name = "YCCK", .pixels = JCS_CMYK, .stored = JCS_YCCK, .components = 4, .sampling = 4},
  };
}

std::string MakeJpeg(const JpegKind& kind, int width_px, int height_px, unsigned seed) {
  std::mt19937 random(seed);
  jpeg_error_mgr errors;
  jpeg_compress_struct jpeg{};
  jpeg.err = jpeg_std_error(&errors);
  errors.error_exit = ThrowJpegError;
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long n_bytes = 0;
  jpeg_mem_dest(&jpeg, &bytes, &n_bytes);
  jpeg.image_width = static_cast<JDIMENSION>(width_px);
  jpeg.image_height = static_cast<JDIMENSION>(height_px);
  jpeg.input_components = kind.components;
  jpeg.in_color_space = static_cast<J_COLOR_SPACE>(kind.pixels);
  Configure(jpeg, kind);
  jpeg_start_compress(&jpeg, TRUE);
  if (kind.orientation > 0) WriteOrientation(jpeg, kind.orientation);
  std::vector<unsigned char> row(static_cast<size_t>(width_px * kind.components));
  for (int y = 0; y < height_px; ++y) {
    for (size_t i = 0; i < row.size(); ++i) {
      const double blot = 128.0 + 100.0 * std::sin(0.07 * static_cast<double>(i) + 3.0 * static_cast<double>(i % 4)) *
                                      std::cos(0.11 * y);
      row[i] = static_cast<unsigned char>(blot + static_cast<double>(random() % 27U));
    }
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&jpeg, &rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  const std::string file(reinterpret_cast<const char*>(bytes), n_bytes);
  std::free(bytes);
  return kind.without_tables ? WithoutTables(file) : file;
}

}  // namespace plslam::test
