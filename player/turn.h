#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>

namespace plslam {

/// Where the sending thread of the player waits for its turn, and what ends the waiting: the pose of the frame that is
/// out, a new reader that needs it again, or the end of the process.
class Turn {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Event { kPose, kNewReader, kTimeout, kStopped };

  /// Frame `frame_id` is about to be sent; poses of other frames do not count.
  void Expect(int64_t frame_id);
  /// A pose has come back.
  void OnPose(int64_t frame_id);
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
  std::optional<int64_t> expected_;
  bool has_pose_ = false;
  std::set<int64_t> readers_;
  bool new_reader_ = false;
  bool stopped_ = false;
};

}  // namespace plslam
