// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace plslam::launcher {

/// What a run that is being played shows of itself.
struct SignsOfLife {
  int64_t poses = 0;  ///< heard so far, also those that were said again
  int64_t map_version = 0;
  /// The player is there and waits for the time of its next frame.
  bool waits_for_time = false;
  bool stream_ended = false;
  double viewer_heard_s = -1.0;  ///< when it last said a word; any clock
};

/// Judges whether a run still gets on. Time is told by the caller.
///
/// While frames come there must be poses, unless the player waits for the next frame's time: that is no stall,
/// however long the gap in the data. Behind the end of the stream only the viewer has work left. It may wait a minute
/// for the map, and says nothing while it writes; who is silent for longer, or has not finished long after the last
/// news, never will.
class StallWatch {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  /// Longer than any frame takes, and than any files, on any machine.
  static constexpr std::chrono::seconds kLimit{120};
  static constexpr std::chrono::seconds kFinishLimit{300};

  /// From here on it is watched.
  void Begin(TimePoint now);
  /// Why the run is to be given up; empty where it is not.
  std::string Look(const SignsOfLife& signs, TimePoint now);

 private:
  SignsOfLife last_;
  TimePoint news_at_;
  TimePoint viewer_at_;
};

}  // namespace plslam::launcher
