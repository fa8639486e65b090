// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/video/film_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "viewer_headless/video/film_stream.h"

namespace plslam::viewer {
namespace {

struct FilmFormat {
  cv::Size size;
  double rate_hz = 0.0;

  bool IsGood() const {
    const auto is_side = [](int px) { return px >= 2 && px <= film_stream::kMaxSide_px && px % 2 == 0; };
    return is_side(size.width) && is_side(size.height) && std::isfinite(rate_hz) && rate_hz > 0.0;
  }
};

void Answer(std::FILE* out, const std::string& line) {
  std::fputs((line + "\n").c_str(), out);
  std::fflush(out);
}

int Refuse(std::FILE* out, const std::string& why) {
  Answer(out, film_stream::kError + why);
  return 1;
}

/// Returns the reason why the file cannot be written, by trying: OpenCV does not report it. Empty if it can be written.
std::string WhyNotWritable(const std::string& part) {
  const std::vector<char> some(64 * 1024);
  errno = 0;
  std::FILE* file = std::fopen(part.c_str(), "ab");
  const bool written = file != nullptr && std::fwrite(some.data(), 1, some.size(), file) == some.size();
  const bool closed = file != nullptr && std::fclose(file) == 0;
  return written && closed ? "" : std::strerror(errno);
}

int RefuseToWrite(std::FILE* out, const std::string& file) {
  const std::string part = film_stream::PartOf(file);
  const std::string why = WhyNotWritable(part);
  std::remove(part.c_str());
  return Refuse(out, fmt::format("{}: cannot be written: {}", file, why.empty() ? "it was truncated" : why));
}

/// The boxes of an MP4 file follow each other up to its end, and include the index, which is written last. OpenCV and
/// FFmpeg continue without an error when a disk is full.
bool IsWholeMp4(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto end = static_cast<uint64_t>(file.tellg());
  bool has_index = false;
  for (uint64_t at = 0; file && at < end;) {
    std::array<unsigned char, 16> head{};
    file.seekg(static_cast<std::streamoff>(at));
    file.read(reinterpret_cast<char*>(head.data()), static_cast<std::streamsize>(std::min<uint64_t>(16, end - at)));
    const auto number = [&head](size_t first, size_t n) {
      uint64_t value = 0;
      for (size_t i = 0; i < n; ++i) value = value << 8U | head[first + i];
      return value;
    };
    uint64_t bytes = number(0, 4);
    if (bytes == 1) bytes = number(8, 8);
    if (bytes < 8 || bytes > end - at) return false;
    has_index = has_index || std::equal(head.begin() + 4, head.begin() + 8, "moov");
    at += bytes;
  }
  return has_index;
}

bool OpenFilm(cv::VideoWriter& writer, const std::string& part, const FilmFormat& format) {
  for (const char* code : {"avc1", "mp4v"}) {
    const int fourcc = cv::VideoWriter::fourcc(code[0], code[1], code[2], code[3]);
    if (writer.open(part, cv::CAP_FFMPEG, fourcc, format.rate_hz, format.size)) return true;
  }
  return false;
}

/// Returns whether the film was completed before the input ended.
bool CopyPictures(std::FILE* in, cv::VideoWriter& writer, const cv::Size& size) {
  cv::Mat picture(size, CV_8UC3);
  const size_t n_bytes = picture.total() * picture.elemSize();
  int mark = std::fgetc(in);
  for (; mark == film_stream::kPicture; mark = std::fgetc(in)) {
    if (std::fread(picture.data, 1, n_bytes, in) != n_bytes) return false;
    writer.write(picture);
  }
  return mark == film_stream::kEnd;
}

}  // namespace

int WriteFilm(const std::string& file, std::FILE* in, std::FILE* out) {
  char line[256];
  if (std::fgets(line, sizeof(line), in) == nullptr) return 0;
  FilmFormat format;
  if (std::sscanf(line, "%d %d %lf", &format.size.width, &format.size.height, &format.rate_hz) != 3 ||
      !format.IsGood()) {
    return Refuse(out, fmt::format("{}: a film needs an even width and height of at most {} pixels, and a rate", file,
                                   film_stream::kMaxSide_px));
  }
  const std::string part = film_stream::PartOf(file);
  cv::VideoWriter writer;
  if (!OpenFilm(writer, part, format)) {
    if (!WhyNotWritable(part).empty()) return RefuseToWrite(out, file);
    std::remove(part.c_str());
    Answer(out, film_stream::kUnable + file + ": OpenCV cannot write MP4 files here");
    return 1;
  }
  Answer(out, film_stream::kReady);
  if (!CopyPictures(in, writer, format.size)) {
    std::remove(part.c_str());
    return Refuse(out, file + ": the pictures ended before the film was complete");
  }
  writer.release();
  if (!IsWholeMp4(part)) return RefuseToWrite(out, file);
  std::error_code error;
  std::filesystem::rename(part, file, error);
  if (error) {
    std::remove(part.c_str());
    return Refuse(out, fmt::format("{}: cannot be renamed: {}", file, error.message()));
  }
  Answer(out, film_stream::kDone);
  return 0;
}

}  // namespace plslam::viewer
