// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <utility>

#include "core/run/recorder.h"
#include "viewer_headless/captions.h"

namespace plslam::viewer {

/// The progress line of a viewer, on standard output if that is a terminal.
class TerminalLine {
 public:
  explicit TerminalLine(bool quiet);

  /// Redraws the line at a time of the steady clock; `last` ends it.
  void Show(const Recorder& recorder, ProgressNumbers numbers, double now_s, bool last);
  /// The frames of a new stream are counted from 0.
  void Restart() { history_.clear(); }

 private:
  double FramesPerSecond(int64_t n_frames, double now_s);

  bool on_terminal_;
  std::deque<std::pair<double, int64_t>> history_;  // (seconds, frames) of the last calls, for the rate
};

}  // namespace plslam::viewer
