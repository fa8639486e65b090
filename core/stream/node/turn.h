// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "core/ids/ids.h"
#include "core/stream/pacing.h"

namespace plslam::stream {

/// Makes the thread that sends frames wait until the pending frame is done: its pose arrives, a new reader needs it
/// again, a reader requests earlier frames, or the process ends; the thread also waits here while the stream is paused.
class Turn {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Event { kPose, kNewReader, kGoBack, kTimeout, kStopped };

  /// This frame is about to be sent; poses of other frames do not count.
  void Expect(const ResumePoint& frame);
  /// Handles a received pose.
  void OnPose(const ResumePoint& frame);
  /// From here on, a pose that arrives before its frame is expected counts too: the stream was begun by an earlier
  /// process.
  void Resume();
  /// The frame with the highest id for which a pose has arrived.
  std::optional<ResumePoint> newest() const;
  /// Notes that the vo_process with this source is running. A source that was seen before causes no event. The first
  /// one does: frames sent before it listened may have been lost to it.
  void OnReader(SourceId source);
  /// Returns whether a vo_process has been seen.
  bool has_reader() const;
  /// Notes that `reader` requests the frames after this one again. A repeated request of the same reader causes no
  /// event.
  void OnGoBack(SourceId reader, const ResumePoint& frame);
  void Stop();

  /// Waits for an event of the expected frame.
  Event WaitForPose(Clock::duration limit);
  /// Waits until a reader requests frames again; false at the limit, or if the process ends first.
  bool WaitForRewind(Clock::duration limit);
  /// After kGoBack: returns the frame after which to resume. Poses that have arrived for later frames are forgotten.
  ResumePoint GoBack();
  /// No effect after Stop.
  void SetPaused(bool paused);
  /// Returns whether new frames may be sent: the stream is neither paused nor stopped.
  bool is_running() const;
  /// Returns kPose at once if the stream is not paused, otherwise as soon as it is resumed.
  Event WaitWhilePaused();
  /// Waits until `time`; false if the process ends first.
  bool WaitUntil(Clock::time_point time);
  bool stopped() const;

 private:
  enum class Course {
    kRunning,
    kPaused,   ///< until SetPaused(false)
    kStopped,  ///< for good
  };
  /// The expected frame.
  enum class Answer {
    kAwaited,    ///< until its pose arrives, or a new reader is seen
    kNewReader,  ///< until that has been reported, or the pose arrives
    kPose,       ///< until the next frame is expected
  };

  bool MustRewind() const { return go_back_ && expected_ && go_back_->frame_id < expected_->frame_id; }
  bool MustEndWait() const { return course_ == Course::kStopped || MustRewind(); }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<ResumePoint> expected_;
  std::optional<ResumePoint> newest_;
  bool resumed_ = false;
  Answer answer_ = Answer::kAwaited;
  std::set<SourceId> readers_;
  std::map<SourceId, ResumePoint> asked_;  // by reader, the newest
  std::optional<ResumePoint> go_back_;
  Course course_ = Course::kRunning;
};

}  // namespace plslam::stream
