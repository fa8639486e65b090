// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/jpeg_codec.h"

#include <turbojpeg.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace plslam {
namespace {

// Of libjpeg.
constexpr int kMaxSide_px = 65500;
// The slow integer transform: its results are the same on every machine. Cameras take ten scans; every further one
// costs a pass over the whole image and a few bytes of the file, so that TurboJPEG's limit of 500 is set.
constexpr int kDecodeFlags = TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS;
// Longer than any segment that could be passed over.
constexpr size_t kTrailerBytes = (1 << 16) + 16;

struct TurboDeleter {
  void operator()(void* turbo) const { tjDestroy(turbo); }
  void operator()(unsigned char* bytes) const { tjFree(bytes); }
};
using Turbo = std::unique_ptr<void, TurboDeleter>;

/// Why the last call failed: the sentence without the name of the function before it.
std::string Reason(const Turbo& turbo) {
  const std::string_view text = tjGetErrorStr2(turbo.get());
  const size_t name = text.find("(): ");
  return std::string(name == std::string_view::npos ? text : text.substr(name + 4));
}

Turbo Opened(tjhandle handle) {
  if (handle == nullptr) throw std::bad_alloc();
  return Turbo(handle);
}

/// Printers' inks are stored as what they leave of the light, and black darkens the other three.
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

cv::Mat GreyOfInks(const cv::Mat& cmyk) {
  cv::Mat grey(cmyk.size(), CV_8UC1);
  for (int y = 0; y < grey.rows; ++y) {
    const uint8_t* const inks = cmyk.ptr<uint8_t>(y);
    for (int x = 0; x < grey.cols; ++x) grey.at<uint8_t>(y, x) = GreyOfInks(inks + 4 * x);
  }
  return grey;
}

struct JpegHeader {
  cv::Size size;
  int colour_space = -1;  ///< TJCS
};

/// Throws where there is no header. A subsampling without a name is an error of TurboJPEG's function, but none of its
/// decoder.
JpegHeader ReadJpegHeader(const Turbo& turbo, std::span<const uint8_t> bytes) {
  JpegHeader header;
  int subsampling = -1;
  const int result = tjDecompressHeader3(turbo.get(), bytes.data(), bytes.size(), &header.size.width,
                                         &header.size.height, &subsampling, &header.colour_space);
  if (header.size.empty() || header.colour_space < 0) {
    throw std::runtime_error(result == 0 ? "it has no image" : Reason(turbo));
  }
  return header;
}

/// The file with the starts of further images behind it, which a decoder refuses: TurboJPEG takes the end of the data
/// for the end of the image.
std::vector<uint8_t> WithTrailer(std::span<const uint8_t> bytes) {
  static const std::vector<uint8_t> kTrailer = [] {
    std::vector<uint8_t> trailer(kTrailerBytes, 0xff);
    for (size_t i = 1; i < trailer.size(); i += 2) trailer[i] = 0xd8;
    return trailer;
  }();
  std::vector<uint8_t> file;
  file.reserve(bytes.size() + kTrailer.size());
  file.insert(file.end(), bytes.begin(), bytes.end());
  file.insert(file.end(), kTrailer.begin(), kTrailer.end());
  return file;
}

/// Into pixels of the file's size; returns why not, or the first warning.
std::string Decode(const Turbo& turbo, std::span<const uint8_t> file, int flags, cv::Mat& pixels) {
  const int format = pixels.channels() == 4 ? TJPF_CMYK : TJPF_GRAY;
  const int result = tjDecompress2(turbo.get(), file.data(), file.size(), pixels.data, pixels.cols,
                                   static_cast<int>(pixels.step), pixels.rows, format, kDecodeFlags | flags);
  return result == 0 ? "" : Reason(turbo);
}

/// The decoder warns of damage that it can pass over, and so do we pass over it. TurboJPEG returns the same for an
/// error behind a warning as for the warning alone, but with the text of the error instead of that of the first
/// warning.
void DecodeWhole(const Turbo& turbo, std::span<const uint8_t> bytes, cv::Mat& pixels) {
  const std::vector<uint8_t> file = WithTrailer(bytes);
  const std::string first = Decode(turbo, file, TJFLAG_STOPONWARNING, pixels);
  if (first.empty()) return;
  const bool warned = tjGetErrorCode(turbo.get()) == TJERR_WARNING;
  const std::string last = warned ? Decode(turbo, file, 0, pixels) : first;
  if (!warned || last != first) {
    const bool in_trailer = last.find("two SOI markers") != std::string::npos;
    throw std::runtime_error(in_trailer ? "it ends too early" : last);
  }
  // With more data ahead the decoder is faster, and makes something else of damage in the last bytes.
  Decode(turbo, bytes, 0, pixels);
}

}  // namespace

cv::Mat DecodeJpeg(std::span<const uint8_t> bytes, cv::Size size) {
  const Turbo turbo = Opened(tjInitDecompress());
  const JpegHeader header = ReadJpegHeader(turbo, bytes);
  if (header.size != size) throw std::runtime_error("its pixels contradict its header");
  const bool inks = header.colour_space == TJCS_CMYK || header.colour_space == TJCS_YCCK;
  cv::Mat pixels(size, inks ? CV_8UC4 : CV_8UC1);
  DecodeWhole(turbo, bytes, pixels);
  return inks ? GreyOfInks(pixels) : pixels;
}

std::string EncodeJpeg(const cv::Mat& grey, int quality) {
  if (grey.empty() || grey.type() != CV_8UC1 || grey.cols > kMaxSide_px || grey.rows > kMaxSide_px) {
    throw std::invalid_argument("a JPEG file is made of an 8-bit grey image of 1 to 65500 pixels a side");
  }
  const Turbo turbo = Opened(tjInitCompress());
  unsigned char* bytes = nullptr;
  unsigned long n_bytes = 0;
  const int result = tjCompress2(turbo.get(), grey.data, grey.cols, static_cast<int>(grey.step), grey.rows, TJPF_GRAY,
                                 &bytes, &n_bytes, TJSAMP_GRAY, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, TurboDeleter> owned(bytes);
  if (result != 0) throw std::runtime_error(Reason(turbo));
  return {reinterpret_cast<const char*>(bytes), n_bytes};
}

}  // namespace plslam
