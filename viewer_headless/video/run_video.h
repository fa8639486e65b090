// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "viewer_headless/video/film_process.h"

namespace plslam::viewer {

/// A film of a run, picture by picture: an MP4 file (H.264) where GStreamer can write one
/// (FilmProcess), and else, or where the name does not end in ".mp4", a folder of numbered PNG files. The first
/// picture decides the size (made even).
class RunVideo {
 public:
  /// `film` has been started for `path` if that is a file. `rate_hz` is in pictures a second. Throws std::runtime_error
  /// if the chosen output cannot be written.
  RunVideo(const std::string& path, std::unique_ptr<FilmProcess> film, double rate_hz, const cv::Size& size);
  /// A file that is not closed is removed.
  ~RunVideo() = default;
  RunVideo(const RunVideo&) = delete;
  RunVideo& operator=(const RunVideo&) = delete;

  /// 8-bit BGR; a picture of another size is scaled. Throws std::runtime_error if it cannot be written, which ends the
  /// video.
  void Add(const cv::Mat& picture);
  /// Completes the video: the file has its final name from here on; until then it ends in ".part.mp4". Throws
  /// std::runtime_error if it cannot be completed or renamed.
  void Close();
  /// The file, or the folder.
  const std::string& path() const { return path_; }
  bool is_folder() const { return film_ == nullptr; }
  /// The reason why it is a folder although a file was requested.
  const std::string& why_folder() const { return why_folder_; }
  int64_t pictures() const { return n_pictures_; }

 private:
  cv::Size size_;
  std::string path_;
  std::string why_folder_;
  std::unique_ptr<FilmProcess> film_;
  bool closed_ = false;
  int64_t n_pictures_ = 0;
};

/// Starts the program that writes `path`; nullptr if that is a folder of pictures.
std::unique_ptr<FilmProcess> StartFilm(const std::string& path);

/// Returns the frame rate of the recording, in pictures a second, from the times of two frames and the number of frames
/// in between; 20 if the times are not usable.
double PictureRate_hz(int64_t t0_ns, int64_t t1_ns, int64_t n_frames);

/// Joins two pictures: side by side, or the second below the first if that is wide.
cv::Mat Join(const cv::Mat& picture, const cv::Mat& map);
/// The size of a map that `Join` puts beside a picture of this size.
cv::Size MapSizeBeside(const cv::Size& picture);

}  // namespace plslam::viewer
