// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/ids/ids.h"
#include "core/io/images/image_file.h"
#include "core/map/keyframe.h"
#include "plslam/pose_t.hpp"
#include "vo_process/node/session_anchor.h"

namespace plslam::vo {

/// The stream that a tracker is tracking, as of its newest frame. Another camera, or a time stamp that goes back,
/// begins another session.
struct TrackerSession {
  SessionId id;
  bool lockstep = false;
  /// Time, number and publisher of the newest frame.
  int64_t last_t_ns = 0;
  FrameId last_frame_id = -1;
  SourceId last_source;
  int64_t last_keyframe_id = -1;
  /// Whether the newest frame became a keyframe, and no relocalisation was requested with it.
  bool follows_keyframe = false;
  SessionAnchor anchor;
  MapId map_id;
  /// Poses of the newest frames, which a player may request again.
  std::deque<pose_t> recent;

  static constexpr size_t kRecentFrames = 16;

  /// Begins the next session of the same stream, without keyframes.
  void Begin(SessionId next_id) {
    id = next_id;
    last_keyframe_id = -1;
    follows_keyframe = false;
    anchor.Begin(last_t_ns);
    recent.clear();
  }

  void Remember(pose_t pose) {
    recent.push_back(std::move(pose));
    if (recent.size() > kRecentFrames) recent.pop_front();
  }

  /// Returns the pose that was published for a frame, if it is one of the newest; nullptr otherwise.
  const pose_t* FindPose(const StereoImages& frame) const {
    const auto found = std::find_if(recent.begin(), recent.end(), [&](const pose_t& pose) {
      return FrameId(pose.frame_id) == frame.frame_id && pose.header.t_ns == frame.t_ns;
    });
    return found == recent.end() ? nullptr : &*found;
  }
};

/// State of a tracker as of a frame that became a keyframe, from which a restarted tracker continues. Later frames are
/// played again, or missing in a live stream.
struct TrackerState {
  /// The configuration; the state is invalid with any other.
  std::string settings;
  /// An encoded camera_t.
  std::vector<uint8_t> camera;
  /// Number of trackers that have continued from it.
  int n_restored = 0;
  TrackerSession session;
  /// As in `MapLink`: 1 or 0.
  uint8_t localise_only = 0;
  uint8_t map_is_fixed = 0;
  int64_t adopted_keyframe_id = -1;
  /// The fields of an Odometry.
  std::vector<uint8_t> odometry;
  /// In lockstep it is published after the state is written, so it may or may not have been sent. -1 if there is none.
  Keyframe keyframe;
};

/// Writes a temporary file and renames it. Returns the size of its content in bytes; `expected_bytes` reserves memory.
/// Throws std::runtime_error that names the file.
size_t WriteTrackerState(const std::string& path, const TrackerState& state, size_t expected_bytes = 0);

/// Throws std::runtime_error that names the file if it cannot be read, is damaged, or has another version.
TrackerState ReadTrackerState(const std::string& path);

/// The state file of a tracker, from which the next one continues.
class TrackerCheckpoint {
 public:
  /// Reads and writes no file if `path` is empty.
  explicit TrackerCheckpoint(std::string path) : path_(std::move(path)) {}

  bool is_on() const { return !path_.empty(); }
  /// Returns the state of an earlier tracker, nullopt if there is none. Throws std::runtime_error with one sentence if
  /// the file is unusable: of other `settings`, damaged, or already used several times by trackers that crashed in
  /// turn.
  std::optional<TrackerState> Take(const std::string& settings) const;
  /// Returns false if writing fails, which is logged once; the file is then removed, because an old state is worse than
  /// none: other processes have received what came after it.
  bool Keep(const TrackerState& state);
  /// Size of `TrackerState::odometry` in the last written state, as a hint for the next one.
  size_t odometry_bytes() const { return odometry_bytes_; }
  void Drop() const;
  /// At an orderly stop: the tracker that took the state has not crashed.
  void Release() const;

 private:
  std::string path_;
  bool has_failed_ = false;
  /// Sizes in bytes of the last written state.
  size_t bytes_ = 0;
  size_t odometry_bytes_ = 0;
};

}  // namespace plslam::vo
