// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace plslam::vo {

/// Whether a session has a known place in the map, so that T_w_odom holds.
///
/// kUnknown until the map has the first keyframe of the session; then kAnchored if that keyframe is connected with the
/// map's first one, otherwise kUnanchored until the session is recognised, by relocalisation or by its keyframes. Once
/// anchored, only a loss of tracking can change that, of which odometry knows (`Odometry::is_unanchored`).
class SessionAnchor {
 public:
  enum class State : uint8_t { kUnknown, kUnanchored, kAnchored };

  /// Begins a session with a frame of this time.
  void Begin(int64_t t_ns) { *this = {}, t_ns_ = t_ns; }

  /// The map has a new keyframe of the session. `connected`: with the map's first keyframe.
  void OnMap(bool connected) {
    if (state_ != State::kAnchored) state_ = connected ? State::kAnchored : State::kUnanchored;
  }

  /// After each frame: whether it was lost, whether it was found by a relocalisation, and whether odometry has
  /// lost its place. Returns whether the frame has no place in the map.
  bool OnFrame(int64_t t_ns, bool lost, bool relocalised, bool odometry_unanchored) {
    if (relocalised && state_ == State::kUnanchored) state_ = State::kAnchored;
    const bool unanchored = odometry_unanchored || state_ == State::kUnanchored;
    if (lost || !unanchored) t_ns_ = t_ns;
    return unanchored;
  }

  State state() const { return state_; }
  bool is_anchored() const { return state_ == State::kAnchored; }
  /// Time of the newest frame that had a place or was lost; of the first frame before that.
  int64_t t_ns() const { return t_ns_; }
  /// Whether the camera has been without a place for a short time only. Requests end then: the map may not have the
  /// place; another robot may map it, or a loop be closed, later.
  bool IsRecent(int64_t t_ns) const {
    // Unsigned: time stamps may have any value.
    return static_cast<uint64_t>(t_ns) - static_cast<uint64_t>(t_ns_) < kRecent_ns;
  }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.state_, self.t_ns_);
  }

 private:
  static constexpr uint64_t kRecent_ns = 3'000'000'000;

  State state_ = State::kUnknown;
  int64_t t_ns_ = 0;
};

}  // namespace plslam::vo
