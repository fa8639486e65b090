// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/ids/ids.h"
#include "core/map/map_follower.h"

namespace plslam {

class run_t;

/// Decides when a reader has all of a run. `plslam run` publishes the end of its run; of processes started by hand only
/// the end of the stream is known, and silence ends the wait for messages that were lost.
class RunEnd {
 public:
  /// The period of `OnTick`.
  static constexpr std::chrono::milliseconds kTick{250};
  /// Longer than a global bundle adjustment, or the restart of a process.
  static constexpr std::chrono::seconds kSilence{60};

  enum class State {
    kByHand,     ///< until stream and tracker have ended and the map is complete, or nothing arrives for `kSilence`
    kAwaited,    ///< under `plslam run`: until it publishes the end, however long that takes
    kAnnounced,  ///< until the announced poses and keyframe have arrived, or nothing arrives for `kSilence`
  };

  /// Parts of the run that a reader has received.
  struct Received {
    bool has_rig = false;
    std::optional<int64_t> n_poses;        ///< frames with a pose; nullopt: the reader uses no poses
    std::optional<KeyframeName> keyframe;  ///< the newest one
    bool is_tracked = false;               ///< as far as is known, nothing but updates of the map is to come
    bool more_may_come = false;            ///< messages of other processes that the reader needs
  };

  /// `has_launcher`: this process was started by `plslam run`.
  explicit RunEnd(bool has_launcher) : has_launcher_(has_launcher) { BeginRun(); }

  /// Returns false for an unknown event.
  bool OnRun(const run_t& message);
  /// A stream has begun, or `ended`.
  void OnStream(bool ended);
  /// A new stream replaces the run before it, whose end was announced or has come by itself.
  void OnNewStream();
  /// A map is made, and is awaited if the run is by hand.
  void OnMapper() { has_mapper_ = true; }
  /// A message about the run has arrived.
  void OnMessage() { quiet_ticks_ = 0; }
  void OnTick() { ++quiet_ticks_; }

  /// Returns whether the run is over. One quiet tick must have passed: the true poses of the last frames, for example,
  /// may arrive after their estimates.
  bool IsOver(const Received& received, const NewestKeyframes& map) const;
  State state() const { return state_; }

 private:
  /// Content of the end of a run.
  struct Announced {
    int64_t n_poses = 0;
    KeyframeName keyframe;  ///< that the map has; number -1: none is to be awaited
  };

  void BeginRun() { state_ = has_launcher_ ? State::kAwaited : State::kByHand; }
  bool HasAll(const Received& received, const NewestKeyframes& map) const;

  bool has_launcher_;
  State state_ = State::kByHand;
  Announced announced_;
  bool stream_ended_ = false;
  bool has_mapper_ = false;
  int64_t quiet_ticks_ = 0;  ///< since the last message
};

}  // namespace plslam
