// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace plslam::launcher {

/// Progress of a run.
struct SignsOfLife {
  int64_t poses = 0;  ///< received so far, including republished ones
  int64_t map_version = 0;
  /// The player is running and waits for the time of its next frame.
  bool waits_for_time = false;
  bool stream_ended = false;
  double viewer_heard_s = -1.0;  ///< time of its last status, by any clock
};

/// Detects a run that does not progress. The caller passes the time.
///
/// While frames are sent there must be poses, unless the player waits for the next frame's time: that is no stall,
/// however long the gap in the data. After the end of the stream mapper and viewer have work left. The viewer publishes
/// no status while it writes; one that is silent for longer, or has not finished long after the last progress, is
/// considered stuck.
class StallWatch {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  /// Longer than any frame takes, and than any files, on any machine.
  static constexpr std::chrono::seconds kLimit{120};
  static constexpr std::chrono::seconds kFinishLimit{300};

  /// Starts the watch.
  void Begin(TimePoint now);
  /// Returns the reason to abort the run; empty if there is none.
  std::string Look(const SignsOfLife& signs, TimePoint now);

 private:
  SignsOfLife last_;
  TimePoint news_at_;
  TimePoint viewer_at_;
};

}  // namespace plslam::launcher
