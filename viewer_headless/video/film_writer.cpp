#include "viewer_headless/video/film_writer.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <system_error>

#include "viewer_headless/video/film_stream.h"

namespace plslam {
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
  fmt::print(out, "{}\n", line);
  std::fflush(out);
}

int Refuse(std::FILE* out, const std::string& why) {
  Answer(out, "error " + why);
  return 1;
}

bool OpenFilm(cv::VideoWriter& writer, const std::string& part, const FilmFormat& format) {
  for (const char* code : {"avc1", "mp4v"}) {
    const int fourcc = cv::VideoWriter::fourcc(code[0], code[1], code[2], code[3]);
    if (writer.open(part, cv::CAP_FFMPEG, fourcc, format.rate_hz, format.size)) return true;
  }
  return false;
}

/// Whether the end of the film came, and not that of the input.
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
    return Refuse(out, fmt::format("{}: a film has two even sides of at most {} pixels and a rate", file,
                                   film_stream::kMaxSide_px));
  }
  const std::string part = film_stream::PartOf(file);
  cv::VideoWriter writer;
  if (!OpenFilm(writer, part, format)) return Refuse(out, file + ": OpenCV cannot write MP4 files here");
  Answer(out, film_stream::kReady);
  if (!CopyPictures(in, writer, format.size)) {
    std::remove(part.c_str());
    return Refuse(out, file + ": the pictures ended before the film");
  }
  writer.release();
  std::error_code error;
  std::filesystem::rename(part, file, error);
  if (error) {
    std::remove(part.c_str());
    return Refuse(out, fmt::format("{}: cannot be put in place: {}", file, error.message()));
  }
  Answer(out, film_stream::kDone);
  return 0;
}

}  // namespace plslam
