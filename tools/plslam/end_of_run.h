// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

namespace plslam::launcher {

/// Signs of the end of a run, as the launcher sees them.
struct EndSigns {
  bool stream_ended = false;
  bool source_sends = false;      ///< its readers lack frames, or frames are requested again
  bool tracker_finished = false;  ///< it has handled the last frame, and its readers have all of its messages
  bool has_all_poses = false;     ///< every frame was answered or skipped, or the last one was answered
  int64_t poses = 0;              ///< received so far, including republished ones
  bool has_map = false;           ///< the newest keyframe is committed, or there is no map
  int64_t map_version = 0;
  bool maps = false;  ///< keyframes wait in a queue of a running process
};

/// Decides when a run is over: no message about one of its frames or keyframes is to come. The caller passes the time.
///
/// A frame of a live stream may have been lost before the tracker, and a keyframe with the tracker that has made it;
/// then silence ends the wait.
class EndOfRun {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  /// A tracker waits 15 s for a silent partner.
  static constexpr std::chrono::seconds kPoseLimit{20};
  /// A killed mapping_process restarts sooner, and a global bundle adjustment takes less.
  static constexpr std::chrono::seconds kMapLimit{60};

  enum class Wait {
    kStream,   ///< until the source has ended the stream and its readers have all frames
    kPoses,    ///< until all poses have arrived and the tracker has finished, or no pose for `kPoseLimit`
    kMap,      ///< until the newest keyframe is committed, or nothing new, and no work left, for `kMapLimit`
    kNothing,  ///< the run is over, and stays so
  };

  Wait Look(const EndSigns& signs, TimePoint now);

 private:
  Wait Next(const EndSigns& signs, TimePoint now) const;

  Wait wait_ = Wait::kStream;
  EndSigns last_;
  TimePoint news_at_;
};

}  // namespace plslam::launcher
