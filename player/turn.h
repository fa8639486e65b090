#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>

#include "player/pacing.h"

namespace plslam {

/// Where the sending thread of the player waits for its turn, and what ends the waiting: the pose of the frame that is
/// out, a new reader that needs it again, or the end of the process.
class Turn {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Event { kPose, kNewReader, kTimeout, kStopped };

  /// This frame is about to be sent; poses of other frames do not count.
  void Expect(const ResumePoint& frame);
  /// A pose has come back.
  void OnPose(const ResumePoint& frame);
  /// From here on a pose that came before its frame was expected counts too: the stream is one that was begun earlier.
  void Resume();
  /// The frame with the highest number that a pose has come of.
  std::optional<ResumePoint> newest() const;
  /// A vo_process with this source lives. The first one, and those seen already, are no news.
  void OnReader(int64_t source);
  void Stop();

  /// Waits for an event of the expected frame.
  Event WaitForPose(Clock::duration limit);
  /// Waits for a time; false where the process ends first.
  bool WaitUntil(Clock::time_point time);
  bool stopped() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<ResumePoint> expected_;
  std::optional<ResumePoint> newest_;
  bool resumed_ = false;
  bool has_pose_ = false;
  std::set<int64_t> readers_;
  bool new_reader_ = false;
  bool stopped_ = false;
};

}  // namespace plslam
