// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/terminal_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstddef>
#include <cstdio>

namespace plslam::viewer {

TerminalLine::TerminalLine(bool quiet) : on_terminal_(!quiet && isatty(STDOUT_FILENO) != 0) {}

double TerminalLine::FramesPerSecond(int64_t n_frames, double now_s) {
  constexpr size_t kRateTicks = 12;
  history_.emplace_back(now_s, n_frames);
  if (history_.size() > kRateTicks) history_.pop_front();
  const double seconds = history_.back().first - history_.front().first;
  const int64_t frames = history_.back().second - history_.front().second;
  return seconds > 0.0 ? static_cast<double>(frames) / seconds : 0.0;
}

void TerminalLine::Show(const Recorder& recorder, ProgressNumbers numbers, double now_s, bool last) {
  numbers.frames_per_s = FramesPerSecond(static_cast<int64_t>(recorder.frames().size()), now_s);
  if (!on_terminal_) return;
  // Overwrite the previous line and clear its rest.
  std::fputs(fmt::format("\r{}\x1b[K{}", ProgressLine(recorder, numbers), last ? "\n" : "").c_str(), stdout);
  std::fflush(stdout);
}

}  // namespace plslam::viewer
