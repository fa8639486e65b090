// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/jpeg_codec.h"

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <type_traits>

// Needs size_t and FILE from above.
#include <jpeglib.h>

#include "core/files/bytes.h"

namespace plslam {
namespace {

// Cameras take ten; every further one costs a pass over the whole image, and a few bytes of the file.
constexpr int kMaxJpegScans = 500;

/// The error manager of libjpeg, with the jump target and its message.
struct JpegErrors {
  jpeg_error_mgr manager;
  std::jmp_buf way_out;
  char reason[JMSG_LENGTH_MAX];
};
static_assert(std::is_standard_layout_v<JpegErrors>, "libjpeg hands back the address of the first member");

[[noreturn]] void GiveUpJpeg(j_common_ptr jpeg) {
  auto* const errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  errors->manager.format_message(jpeg, errors->reason);
  std::longjmp(errors->way_out, 1);
}

void SayNothingOfJpeg(j_common_ptr /*jpeg*/) {}

[[noreturn]] void GiveUpJpegFor(j_common_ptr jpeg, const char* why) {
  auto* const errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  std::snprintf(errors->reason, sizeof(errors->reason), "%s", why);
  std::longjmp(errors->way_out, 1);
}

boolean EndOfJpegBytes(j_decompress_ptr jpeg) {
  GiveUpJpegFor(reinterpret_cast<j_common_ptr>(jpeg), "it is truncated");
}

void LimitJpegScans(j_common_ptr jpeg) {
  const auto* const decoder = reinterpret_cast<j_decompress_ptr>(jpeg);
  if (decoder->is_decompressor != 0 && decoder->input_scan_number > kMaxJpegScans) {
    GiveUpJpegFor(jpeg, "it has more than 500 scans");
  }
}

/// Returns whether `steps` completed. An error of libjpeg leaves it by longjmp, past stack frames that must have no
/// destructors: its own, and those of `steps`.
template <class Steps>
bool RunJpegSteps(JpegErrors& errors, const Steps& steps) {
  if (setjmp(errors.way_out) != 0) return false;
  steps();
  return true;
}

/// The structure of libjpeg for one direction, freed at the end of the scope.
template <class Jpeg>
class JpegHandle {
 public:
  JpegHandle() {
    jpeg_.err = jpeg_std_error(&errors_.manager);
    errors_.manager.error_exit = GiveUpJpeg;
    errors_.manager.output_message = SayNothingOfJpeg;
  }
  // The library frees nothing for an object that was never created.
  ~JpegHandle() { jpeg_destroy(reinterpret_cast<j_common_ptr>(&jpeg_)); }
  JpegHandle(const JpegHandle&) = delete;
  JpegHandle& operator=(const JpegHandle&) = delete;

  template <class Steps>
  void Run(const Steps& steps) {
    if (!RunJpegSteps(errors_, steps)) throw std::runtime_error(errors_.reason);
  }
  Jpeg& jpeg() { return jpeg_; }

 private:
  JpegErrors errors_{};
  Jpeg jpeg_{};
};

/// A destination for libjpeg: a string.
struct JpegSink {
  jpeg_destination_mgr manager;
  std::string* file;
  JOCTET waiting[4096];
};
static_assert(std::is_standard_layout_v<JpegSink>, "libjpeg hands back the address of the first member");

void BeginJpegSink(j_compress_ptr jpeg) {
  auto& sink = *reinterpret_cast<JpegSink*>(jpeg->dest);
  sink.manager.next_output_byte = sink.waiting;
  sink.manager.free_in_buffer = sizeof(sink.waiting);
}

void EmptyJpegSink(j_compress_ptr jpeg, size_t n) {
  const auto& sink = *reinterpret_cast<JpegSink*>(jpeg->dest);
  if (!AppendBytes(*sink.file, sink.waiting, n)) {
    GiveUpJpegFor(reinterpret_cast<j_common_ptr>(jpeg), "out of memory");
  }
  BeginJpegSink(jpeg);
}

boolean EmptyFullJpegSink(j_compress_ptr jpeg) {
  EmptyJpegSink(jpeg, sizeof(JpegSink::waiting));
  return TRUE;
}

void EndJpegSink(j_compress_ptr jpeg) { EmptyJpegSink(jpeg, sizeof(JpegSink::waiting) - jpeg->dest->free_in_buffer); }

/// Inks are stored as the share of light that they leave, and black darkens the other three.
uint8_t GreyOfInks(const uint8_t* cmyk) {
  constexpr int kShift = 14;
  constexpr int kRed = 4899;
  constexpr int kGreen = 9617;
  constexpr int kBlue = (1 << kShift) - kRed - kGreen;
  const int black = cmyk[3];
  const auto light = [&](int ink) { return black - (((255 - ink) * black) >> 8); };
  const int sum = kRed * light(cmyk[0]) + kGreen * light(cmyk[1]) + kBlue * light(cmyk[2]);
  return static_cast<uint8_t>((sum + (1 << (kShift - 1))) >> kShift);
}

void ReadJpegRows(jpeg_decompress_struct& jpeg, cv::Mat& image) {
  JSAMPARRAY const inks =
      jpeg.out_color_components == 4
          ? jpeg.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&jpeg), JPOOL_IMAGE, 4 * jpeg.output_width, 1)
          : nullptr;
  for (int y = 0; y < image.rows; ++y) {
    uint8_t* const row = image.ptr<uint8_t>(y);
    JSAMPROW in_place = row;
    jpeg_read_scanlines(&jpeg, inks == nullptr ? &in_place : inks, 1);
    if (inks == nullptr) continue;
    for (int x = 0; x < image.cols; ++x) row[x] = GreyOfInks(inks[0] + 4 * x);
  }
}

}  // namespace

cv::Mat DecodeJpeg(std::span<const uint8_t> bytes, cv::Size size) {
  JpegHandle<jpeg_decompress_struct> handle;
  jpeg_decompress_struct& jpeg = handle.jpeg();
  jpeg_progress_mgr watch{};
  watch.progress_monitor = LimitJpegScans;
  handle.Run([&] {
    jpeg_create_decompress(&jpeg);
    jpeg.progress = &watch;
    jpeg_mem_src(&jpeg, bytes.data(), bytes.size());
    jpeg.src->fill_input_buffer = EndOfJpegBytes;
    jpeg_read_header(&jpeg, TRUE);
    jpeg.out_color_space = jpeg.num_components == 4 ? JCS_CMYK : JCS_GRAYSCALE;
  });
  if (jpeg.image_width != static_cast<JDIMENSION>(size.width) ||
      jpeg.image_height != static_cast<JDIMENSION>(size.height)) {
    throw std::runtime_error("its pixels contradict its header");
  }
  cv::Mat image(size, CV_8UC1);
  handle.Run([&] {
    jpeg_start_decompress(&jpeg);
    ReadJpegRows(jpeg, image);
  });
  return image;
}

std::string EncodeJpeg(const cv::Mat& grey, int quality) {
  if (grey.empty() || grey.type() != CV_8UC1 || grey.cols > JPEG_MAX_DIMENSION || grey.rows > JPEG_MAX_DIMENSION) {
    throw std::invalid_argument("a JPEG file needs an 8-bit grey image of 1 to 65500 pixels per side");
  }
  JpegHandle<jpeg_compress_struct> handle;
  jpeg_compress_struct& jpeg = handle.jpeg();
  std::string file;
  JpegSink sink{{nullptr, 0, BeginJpegSink, EmptyFullJpegSink, EndJpegSink}, &file, {}};
  handle.Run([&] {
    jpeg_create_compress(&jpeg);
    jpeg.dest = &sink.manager;
    jpeg.image_width = static_cast<JDIMENSION>(grey.cols);
    jpeg.image_height = static_cast<JDIMENSION>(grey.rows);
    jpeg.input_components = 1;
    jpeg.in_color_space = JCS_GRAYSCALE;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, quality, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    for (int y = 0; y < grey.rows; ++y) {
      // The interface is not const-correct; the library does not change the row.
      JSAMPROW row = const_cast<uint8_t*>(grey.ptr<uint8_t>(y));
      jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
  });
  return file;
}

}  // namespace plslam
