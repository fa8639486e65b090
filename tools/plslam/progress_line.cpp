#include "tools/plslam/progress_line.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

namespace plslam {

std::string FormatProgress(const Progress& p, int width) {
  const std::string total = p.total_frames >= 0 ? fmt::format("/{}", p.total_frames) : "";
  std::string line = fmt::format("frame {}{}  {:.1f}/s  {}  points {}  lines {}  keyframes {}", p.frames, total,
                                 p.rate_hz, p.state, p.tracked_points, p.tracked_lines, p.keyframes);
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

void ProgressLine::Say(const std::string& sentence) {
  Clear();
  std::fputs(fmt::format("plslam: {}\n", sentence).c_str(), stderr);
}

}  // namespace plslam
