// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/video/run_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/io/images/png_codec.h"

namespace plslam::viewer {
namespace {

constexpr double kWide = 2.0;
constexpr int kPictureCompression = 3;

}  // namespace

std::unique_ptr<FilmProcess> StartFilm(const std::string& path) {
  return path.ends_with(".mp4") ? std::make_unique<FilmProcess>(path) : nullptr;
}

RunVideo::RunVideo(const std::string& path, std::unique_ptr<FilmProcess> film, double rate_hz, const cv::Size& size)
    : size_((size.width + 1) / 2 * 2, (size.height + 1) / 2 * 2), path_(path), film_(std::move(film)) {
  if (film_) {
    MakeFolder(std::filesystem::path(path).parent_path().string());
    try {
      film_->Begin(rate_hz, size_);
      return;
    } catch (const NoFilmsHere& e) {
      why_folder_ = e.what();
    }
    film_.reset();
    path_ = path.substr(0, path.size() - 4);
  }
  MakeFolder(path_);
}

void RunVideo::Close() {
  if (film_ && !std::exchange(closed_, true)) film_->Finish();
}

void RunVideo::Add(const cv::Mat& picture) {
  cv::Mat scaled = picture;
  if (picture.size() != size_) cv::resize(picture, scaled, size_, 0, 0, cv::INTER_AREA);
  if (film_) {
    film_->Add(scaled);
  } else {
    WritePng(fmt::format("{}/{:06}.png", path_, n_pictures_), scaled, kPictureCompression);
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

}  // namespace plslam::viewer
