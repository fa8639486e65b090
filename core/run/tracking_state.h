// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plslam {

/// State of the tracker at a frame; the numbers of `pose_t.state`.
enum class TrackingState { kInitialising = 0, kTracking = 1, kWeak = 2, kLost = 3, kRecovered = 4 };

inline constexpr std::array<const char*, 5> kTrackingStateNames{"initialising", "tracking", "weak", "lost",
                                                                "recovered"};

inline bool IsTrackingState(int64_t number) {
  return number >= 0 && number < static_cast<int64_t>(kTrackingStateNames.size());
}

/// "initialising", "tracking", "weak", "lost", "recovered"; "unknown" of a number that is no state.
inline std::string TrackingStateName(TrackingState state) {
  return IsTrackingState(static_cast<int>(state)) ? kTrackingStateNames[static_cast<size_t>(state)] : "unknown";
}

/// A frame is tracked if its pose is estimated: neither the identity before the first map (initialising), nor a
/// prediction of the motion model (lost). The frame that starts a session is tracked, by definition; it is the keyframe
/// among the initialising ones. `keyframe_id` is -1 if the frame is no keyframe.
inline bool IsTracked(TrackingState state, int64_t keyframe_id) {
  if (state == TrackingState::kInitialising) return keyframe_id >= 0;
  return IsTrackingState(static_cast<int>(state)) && state != TrackingState::kLost;
}

}  // namespace plslam
