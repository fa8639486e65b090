// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace plslam::launcher {

/// The values of the progress line.
struct Progress {
  int64_t frames = 0;
  int64_t total_frames = -1;  ///< -1: unknown
  double rate_hz = 0.0;
  int tracked_points = 0;
  int tracked_lines = 0;
  int64_t keyframes = 0;
  std::string state;
  int64_t lost_messages = 0;
  int64_t skipped_frames = 0;
  int restarts = 0;
  /// The process that does not keep up, if any.
  std::string lag;
};

/// One line of text, without a line end, at most `width` characters long.
std::string FormatProgress(const Progress& progress, int width);

/// Redraws the line on stderr if that is a terminal; otherwise prints nothing. A closed terminal is no error.
class ProgressLine {
 public:
  explicit ProgressLine(bool enabled);
  /// Leaves the cursor on a fresh line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void Show(const Progress& progress);
  void Clear();
  /// "plslam: SENTENCE" on a separate line, which remains; on a terminal or not.
  void PrintSentence(const std::string& sentence);

 private:
  bool enabled_;
  bool drawn_ = false;
};

}  // namespace plslam::launcher
