// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/progress_line.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace plslam::launcher {

namespace {

/// With fewer frames, the rate is not meaningful.
constexpr int64_t kEnoughFrames = 20;

/// "45 s", "12 min", "3 h 20 min".
std::string DurationText(double seconds) {
  if (seconds < 99.5) return fmt::format("{:.0f} s", seconds);
  const auto minutes = static_cast<int64_t>(std::lround(seconds / 60.0));
  return minutes < 100 ? fmt::format("{} min", minutes) : fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

}  // namespace

std::string FormatProgress(const Progress& p, int width) {
  const std::string total = p.total_frames >= 0 ? fmt::format("/{}", p.total_frames) : "";
  const double left = static_cast<double>(p.total_frames - p.frames);
  const bool knows_left = left > 0.0 && p.frames >= kEnoughFrames && p.rate_hz > 0.0;
  const std::string rest = knows_left ? fmt::format("  {} left", DurationText(left / p.rate_hz)) : "";
  std::string line = fmt::format("frame {}{}  {:.1f}/s{}  {}  points {}  lines {}  keyframes {}", p.frames, total,
                                 p.rate_hz, rest, p.state, p.tracked_points, p.tracked_lines, p.keyframes);
  if (p.skipped_frames > 0) line += fmt::format("  skipped {}", p.skipped_frames);
  line += fmt::format("  gaps {}", p.lost_messages);
  if (p.restarts > 0) line += fmt::format("  restarts {}", p.restarts);
  if (!p.lag.empty()) line += "  " + p.lag;
  return line.substr(0, static_cast<size_t>(width > 0 ? width : 0));
}

ProgressLine::ProgressLine(bool enabled) : enabled_(enabled && isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() { Clear(); }

void ProgressLine::Show(const Progress& progress) {
  if (!enabled_) return;
  winsize size{};
  const int width = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1 : 79;
  std::fputs(fmt::format("\r\033[K{}", FormatProgress(progress, width)).c_str(), stderr);
  std::fflush(stderr);
  drawn_ = true;
}

void ProgressLine::Clear() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

void ProgressLine::PrintSentence(const std::string& sentence) {
  Clear();
  std::fputs(fmt::format("plslam: {}\n", sentence).c_str(), stderr);
}

}  // namespace plslam::launcher
