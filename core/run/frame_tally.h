// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/ids/ids.h"
#include "core/run/tracking_state.h"

namespace plslam {

/// Returns `tracked` of `all` frames in per cent, rounded down to a tenth, so that 100 means every frame; nullopt
/// without frames.
inline std::optional<double> TrackedPercent(double tracked, double all) {
  if (!(all > 0.0)) return std::nullopt;
  return std::floor(1000.0 * std::clamp(tracked / all, 0.0, 1.0) + 1e-9) / 10.0;
}

/// Counts of a run's frames by outcome. Each frame is counted once; shares of tracked frames are relative to `all`.
struct FrameTally {
  int64_t tracked = 0;
  int64_t initialising = 0;  ///< no features yet from which a map could be initialised
  int64_t lost = 0;
  int64_t skipped = 0;     ///< dropped by a tracker that was too slow, in real time
  int64_t unreadable = 0;  ///< skipped by the player (--skip-bad); the tracker never receives them
  int64_t unanswered = 0;  ///< sent, but the tracker exited before it published a pose

  /// Counts a frame that has a pose message; `sign` -1 takes it back.
  void Count(TrackingState state, int64_t keyframe_id, int64_t sign = 1) {
    int64_t& part = IsTracked(state, keyframe_id)           ? tracked
                    : state == TrackingState::kInitialising ? initialising
                                                            : lost;
    part += sign;
  }
  /// Frames with a pose message.
  int64_t answered() const { return tracked + initialising + lost; }
  int64_t all() const { return answered() + skipped + unreadable + unanswered; }
  std::optional<double> tracked_percent() const {
    return TrackedPercent(static_cast<double>(tracked), static_cast<double>(all()));
  }
  bool operator==(const FrameTally&) const = default;
};

/// Moving bodies in a run, accumulated frame by frame.
struct MovingTally {
  int64_t bodies = 0;          ///< distinct bodies
  int64_t frames = 0;          ///< frames with at least one moving body
  double largest_share = 0.0;  ///< largest share of a frame's features on moving bodies
  FrameId first_frame = -1;
  FrameId last_frame = -1;

  void Add(FrameId frame_id, int64_t n_moving, int64_t n_features, int64_t n_bodies) {
    bodies = std::max(bodies, n_bodies);
    if (n_moving <= 0) return;
    ++frames;
    if (n_features > 0) {
      largest_share = std::max(largest_share, static_cast<double>(n_moving) / static_cast<double>(n_features));
    }
    if (first_frame < 0) first_frame = frame_id;
    last_frame = std::max(last_frame, frame_id);
  }
};

/// Counts of the frames that the player has sent and could not read, from its status and the end of the stream.
class SentFrames {
 public:
  void OnStatus(int64_t sent, int64_t unreadable) {
    sent_ = sent;
    // An interrupted run receives no end of the stream.
    unreadable_ = std::max(unreadable_, unreadable);
  }
  void OnStream(bool is_end, int64_t n_frames, int64_t n_bad) {
    in_all_ = is_end ? std::optional(n_frames) : std::nullopt;
    unreadable_ = n_bad;
  }
  bool ended() const { return in_all_.has_value(); }
  /// From the player's status, up to a second old.
  int64_t sent() const { return sent_; }
  int64_t unreadable() const { return unreadable_; }
  /// Returns the number of sent frames that are neither answered nor skipped, for example those after the last pose.
  int64_t Unanswered(const FrameTally& tally) const {
    return std::max<int64_t>(0, in_all_.value_or(sent_) - tally.answered() - tally.skipped);
  }
  /// Number of frames sent after `newest_frame`, the newest one that has a pose (ids count from 0; -1: none has). Older
  /// frames without a pose are not counted: they will not be answered.
  int64_t Behind(FrameId newest_frame) const {
    return std::max<int64_t>(0, in_all_.value_or(sent_) - newest_frame.value - 1);
  }

 private:
  int64_t sent_ = 0;
  int64_t unreadable_ = 0;
  std::optional<int64_t> in_all_;
};

}  // namespace plslam
