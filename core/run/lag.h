// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

namespace plslam {

/// A process whose status comes every second is gone when nothing was heard of it for so long.
inline constexpr double kGoneAfter_s = 10.0;

/// Whether a process keeps up, for the line of the launcher and the page of the viewer.
enum class Pace {
  kKeepsUp,
  kBehind,  ///< more waits in its longest queue than is usual
  kSilent,  ///< it has missed two statuses
  kGone,    ///< it has stopped, or has said nothing for so long that it counts as dead
};

/// From the last status of a process: its state, for how long it has said nothing since, and its longest queue.
Pace PaceOf(std::string_view state, double silent_s, double longest_queue);
std::string_view PaceName(Pace pace);

/// How many frames a process that handles keyframes is behind the newest pose: those since the oldest of the
/// `waiting_keyframes` newest keyframes was made. `is_keyframe(i)` is asked of the frames with a pose, the newest
/// (i = 0) first, of which there are `n_frames`. How far that pose is behind the player is SentFrames::Behind.
int64_t FramesBehind(int64_t waiting_keyframes, int64_t n_frames, const std::function<bool(int64_t)>& is_keyframe);

}  // namespace plslam
