// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "core/stream/pacing.h"

namespace plslam::stream {

/// Where the thread that sends frames waits for its turn, and what ends the waiting: the pose of the frame that is out,
/// a new reader that needs it again, one that needs frames before it again, or the end of the process; and where it
/// waits while somebody has paused it.
class Turn {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Event { kPose, kNewReader, kGoBack, kTimeout, kStopped };

  /// This frame is about to be sent; poses of other frames do not count.
  void Expect(const ResumePoint& frame);
  /// A pose has come back.
  void OnPose(const ResumePoint& frame);
  /// From here on a pose that came before its frame was expected counts too: the stream is one that was begun
  /// earlier.
  void Resume();
  /// The frame with the highest number that a pose has come of.
  std::optional<ResumePoint> newest() const;
  /// A vo_process with this source lives. Those seen already are no news. The first one is: what was sent before it
  /// listened, others may have taken.
  void OnReader(int64_t source);
  /// `reader` wants the frames behind this one once more. Said again by the same reader it is no news.
  void OnGoBack(int64_t reader, const ResumePoint& frame);
  void Stop();

  /// Waits for an event of the expected frame.
  Event WaitForPose(Clock::duration limit);
  /// Waits until somebody wants frames again; false at the limit, or where the process ends first.
  bool WaitForGoBack(Clock::duration limit);
  /// After kGoBack: behind which frame to go on. The poses that have come of those after it do not count any more.
  ResumePoint GoBack();
  void SetPaused(bool paused);
  bool paused() const;
  /// kPose: at once, or as soon as nobody has paused it any more.
  Event WaitWhilePaused();
  /// Waits for a time; false where the process ends first.
  bool WaitUntil(Clock::time_point time);
  bool stopped() const;

 private:
  bool MustGoBack() const { return go_back_ && expected_ && go_back_->frame_id < expected_->frame_id; }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<ResumePoint> expected_;
  std::optional<ResumePoint> newest_;
  bool resumed_ = false;
  bool has_pose_ = false;
  std::set<int64_t> readers_;
  bool new_reader_ = false;
  std::map<int64_t, ResumePoint> asked_;  // by reader, the newest
  std::optional<ResumePoint> go_back_;
  bool paused_ = false;
  bool stopped_ = false;
};

}  // namespace plslam::stream
