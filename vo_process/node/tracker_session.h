// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>

#include "plslam/pose_t.hpp"

namespace plslam {

/// The stream that a tracker is tracking, as of its newest frame. Another camera, or time that goes back, begins
/// another session.
struct TrackerSession {
  int64_t id = 0;
  bool lockstep = false;
  /// Of the newest frame: its time, its number and who published it.
  int64_t last_t_ns = 0;
  int64_t last_frame_id = -1;
  int64_t last_source = 0;
  int64_t last_keyframe_id = -1;
  /// Whether the newest frame became a keyframe, and no relocalisation was requested with it.
  bool follows_keyframe = false;
  /// Time of the newest frame in which the camera was anchored in the map, or was lost.
  int64_t anchored_t_ns = 0;
  /// Poses of the newest frames, which a player may ask for again.
  std::deque<pose_t> recent;

  static constexpr size_t kRecentFrames = 16;

  void Remember(pose_t pose) {
    recent.push_back(std::move(pose));
    if (recent.size() > kRecentFrames) recent.pop_front();
  }

  /// The pose that was published for a frame, if it is one of the newest; nullptr otherwise.
  const pose_t* FindPose(int64_t frame_id, int64_t t_ns) const {
    const auto found = std::find_if(recent.begin(), recent.end(), [&](const pose_t& pose) {
      return pose.frame_id == frame_id && pose.header.t_ns == t_ns;
    });
    return found == recent.end() ? nullptr : &*found;
  }
};

}  // namespace plslam
