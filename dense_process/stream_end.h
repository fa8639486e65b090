// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/ids/ids.h"
#include "core/map/map_follower.h"

namespace plslam::dense {

/// Decides when all of a stream is in the map: the stream has ended, the tracker has finished, the newest keyframe is
/// committed, and no message has arrived for `kQuietTicks`. After `kQuietTicksForTheMap` the map counts as complete
/// without its newest keyframe: mapping_process has exited.
class StreamEnd {
 public:
  /// Ticks come four times a second.
  static constexpr int kQuietTicks = 2;
  static constexpr int kQuietTicksForTheMap = 240;

  /// A stream has begun, or `ended`.
  void OnStream(bool ended) {
    ended_ = ended;
    OnMessage();
  }
  void OnTracker(bool finished) { tracker_finished_ = finished; }
  void OnKeyframe(const KeyframeName& keyframe) {
    newest_ = keyframe;
    OnMessage();
  }
  /// Images, or an update of the map, have arrived.
  void OnMessage() { quiet_ticks_ = 0; }
  void OnTick() { ++quiet_ticks_; }

  bool IsOver(const NewestKeyframes& map) const {
    if (!ended_ || quiet_ticks_ <= kQuietTicks) return false;
    const bool complete = tracker_finished_ && newest_ && map.HasCommitted(*newest_);
    return complete || quiet_ticks_ > kQuietTicksForTheMap;
  }

 private:
  bool ended_ = false;
  bool tracker_finished_ = false;
  std::optional<KeyframeName> newest_;
  int quiet_ticks_ = 0;
};

}  // namespace plslam::dense
