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

/// A film that plslam_film writes: a program of its own, so that nobody who wants no film loads the 250 libraries of
/// OpenCV's videoio. It starts at once, and has loaded them when the first picture comes. Where it dies or says no,
/// `Begin`, `Add` and `Finish` throw std::runtime_error with one sentence, and it is over.
class FilmProcess {
 public:
  /// `file` ends in ".mp4". What cannot be started is told by `Begin`.
  explicit FilmProcess(const std::string& file, const std::filesystem::path& program = FilmProgram());
  /// Of a film that is not finished nothing is left.
  ~FilmProcess();
  FilmProcess(const FilmProcess&) = delete;
  FilmProcess& operator=(const FilmProcess&) = delete;

  pid_t pid() const { return pid_; }
  /// Once, before the first picture. Sides are even. Throws NoFilmsHere, too.
  void Begin(double rate_hz, cv::Size size);
  /// 8-bit BGR, of that size.
  void Add(const cv::Mat& picture);
  /// No more pictures: the file is there, whole, when this returns.
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
