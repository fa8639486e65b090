#include "viewer_headless/video/run_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <system_error>

#include "core/io/atomic_file.h"
#include "core/io/png_file.h"

namespace plslam {
namespace {

constexpr double kWide = 2.0;

}  // namespace

struct RunVideo::Film {
  std::string part;
  cv::VideoWriter writer;

  bool Open(const std::string& path, double rate_hz, const cv::Size& size) {
    part = path.substr(0, path.size() - 4) + ".part.mp4";
    for (const char* code : {"avc1", "mp4v"}) {
      if (writer.open(part, cv::CAP_FFMPEG, cv::VideoWriter::fourcc(code[0], code[1], code[2], code[3]), rate_hz,
                      size)) {
        return true;
      }
    }
    return false;
  }

  /// Once; later nothing is to be done.
  std::error_code Close(const std::string& path) {
    std::error_code error;
    if (!writer.isOpened()) return error;
    writer.release();
    std::filesystem::rename(part, path, error);
    return error;
  }
};

RunVideo::RunVideo(const std::string& path, double rate_hz, const cv::Size& size)
    : size_((size.width + 1) / 2 * 2, (size.height + 1) / 2 * 2), path_(path) {
  if (path.ends_with(".mp4")) {
    MakeFolder(std::filesystem::path(path).parent_path().string());
    film_ = std::make_unique<Film>();
    if (film_->Open(path, rate_hz, size_)) return;
    film_.reset();
    path_ = path.substr(0, path.size() - 4);
  }
  MakeFolder(path_);
}

RunVideo::~RunVideo() {
  if (film_) film_->Close(path_);
}

void RunVideo::Close() {
  const std::error_code error = film_ ? film_->Close(path_) : std::error_code();
  if (error) throw std::runtime_error(fmt::format("{}: cannot be put in place: {}", path_, error.message()));
}

bool RunVideo::is_folder() const { return film_ == nullptr; }

void RunVideo::Add(const cv::Mat& picture) {
  cv::Mat scaled = picture;
  if (picture.size() != size_) cv::resize(picture, scaled, size_, 0, 0, cv::INTER_AREA);
  if (film_) {
    film_->writer.write(scaled);
  } else {
    WritePng(fmt::format("{}/{:06}.png", path_, n_pictures_), scaled, 3);
  }
  ++n_pictures_;
}

double PictureRate_hz(int64_t t0_ns, int64_t t1_ns, int64_t n_frames) {
  if (t1_ns <= t0_ns || n_frames <= 0) return 20.0;
  const double rate_hz = 1e9 * static_cast<double>(n_frames) / static_cast<double>(t1_ns - t0_ns);
  return std::clamp(rate_hz, 1.0, 120.0);
}

cv::Size MapSizeBeside(const cv::Size& picture) {
  if (picture.width > kWide * picture.height) return {picture.width, picture.width / 2};
  return {picture.height, picture.height};
}

cv::Mat Join(const cv::Mat& picture, const cv::Mat& map) {
  cv::Mat joined;
  if (picture.cols == map.cols) {
    cv::vconcat(picture, map, joined);
  } else {
    cv::hconcat(picture, map, joined);
  }
  return joined;
}

}  // namespace plslam
