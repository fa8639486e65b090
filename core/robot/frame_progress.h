// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace plslam::robot {

/// Whether a live source sends frames, and for how long it has sent none. Times by the steady clock, in s.
class FrameProgress {
 public:
  /// Time without frames after which the reason is reported: discovery takes two to three seconds.
  static constexpr double kPatience_s = 4.0;

  explicit FrameProgress(double now_s) : progress_s_(now_s) {}

  /// Returns whether frames were sent since the last call. `n_sent`: frames since the start.
  bool HasProgress(int64_t n_sent, double now_s) {
    if (n_sent <= n_sent_) return false;
    n_sent_ = n_sent;
    progress_s_ = now_s;
    return true;
  }
  bool IsLate(double now_s) const { return now_s - progress_s_ >= kPatience_s; }

 private:
  int64_t n_sent_ = 0;
  double progress_s_;  ///< time of the last progress
};

}  // namespace plslam::robot
