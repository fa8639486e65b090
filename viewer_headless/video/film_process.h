// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <stdexcept>
#include <string>

namespace plslam::viewer {

/// The program plslam_film, beside this one.
std::filesystem::path FilmProgram();

/// This machine cannot write films, wherever they are to be: the program does not run, or has no encoder.
class NoFilmsHere : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A film that is written by plslam_film, a separate program, so that a run without a film does not load GStreamer and
/// its plug-ins. It is started in the constructor, so that its libraries are loaded when the first
/// picture arrives. If it exits or reports an error, `Begin`, `Add` and `Finish` throw std::runtime_error with one
/// sentence, and the film is aborted.
class FilmProcess {
 public:
  /// `file` ends in ".mp4". A failure to start is reported by `Begin`.
  explicit FilmProcess(const std::string& file, const std::filesystem::path& program = FilmProgram());
  /// An unfinished film leaves no file.
  ~FilmProcess();
  FilmProcess(const FilmProcess&) = delete;
  FilmProcess& operator=(const FilmProcess&) = delete;

  pid_t pid() const { return pid_; }
  /// Called once, before the first picture. Both sides are even. Also throws NoFilmsHere.
  void Begin(double rate_hz, cv::Size size);
  /// 8-bit BGR, of that size.
  void Add(const cv::Mat& picture);
  /// Completes the film: the file exists and is complete on return.
  void Finish();

 private:
  void Send(const void* bytes, size_t n);
  /// Reads a line; anything else than `expected` is why it went wrong.
  void Await(const std::string& expected);
  [[noreturn]] void FailWithEnd();
  /// Closes the connection, which ends the program, and waits for that. Returns how it ended.
  std::string End();

  std::string file_;
  std::string program_;
  std::string start_error_;
  pid_t pid_ = -1;
  int socket_ = -1;
  bool begun_ = false;
};

}  // namespace plslam::viewer
