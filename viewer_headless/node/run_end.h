// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

#include "core/ids/ids.h"
#include "core/map/map_follower.h"
#include "core/run/recorder.h"

namespace plslam::viewer {

/// Decides when the results of a run are complete. `plslam run` publishes the end of its run; of processes started by
/// hand only the end of the player's stream is known, and silence ends the wait for messages that were lost.
class RunEnd {
 public:
  /// Longer than a global bundle adjustment, or the restart of a process.
  static constexpr std::chrono::seconds kSilence{60};

  enum class State {
    kByHand,     ///< until the stream has ended, and poses, map and pictures are complete, or silent for `kSilence`
    kAwaited,    ///< under `plslam run`: until it publishes the end, however long that takes
    kAnnounced,  ///< until the announced poses and keyframe have arrived, or nothing has for `kSilence`
  };

  /// Content of the end of a run.
  struct Announced {
    int64_t n_poses = 0;
    KeyframeName keyframe;  ///< that the map has; number -1: none is to be awaited
  };

  /// Received parts beside the poses.
  struct Received {
    bool has_rig = false;
    bool pictures_may_come = false;
    bool surfaces_may_come = false;
  };

  /// `has_launcher`: this process was started by `plslam run`.
  explicit RunEnd(bool has_launcher) : has_launcher_(has_launcher) { BeginRun(); }

  /// `plslam run` has begun a run, or ended it.
  void OnBegin() { state_ = State::kAwaited; }
  void OnEnd(const Announced& announced);
  /// A map is made, and is awaited if the run is by hand.
  void OnMapper() { has_mapper_ = true; }
  /// A new stream replaces the run before it, whose end was announced or has come by itself.
  void OnNewStream();

  /// Returns whether the run is over, `silence` after the last message about it.
  bool IsOver(const Recorder& recorder, const NewestKeyframes& map, const Received& received,
              std::chrono::milliseconds silence) const;
  State state() const { return state_; }

 private:
  void BeginRun() { state_ = has_launcher_ ? State::kAwaited : State::kByHand; }
  bool HasMap(const Recorder& recorder, const NewestKeyframes& map) const;

  bool has_launcher_;
  State state_ = State::kByHand;
  Announced announced_;
  bool has_mapper_ = false;
};

}  // namespace plslam::viewer
