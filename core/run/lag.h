// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

namespace plslam {

/// A process, whose status arrives every second, counts as exited after a silence of this length.
inline constexpr double kGoneAfter_s = 10.0;

/// Whether a process keeps up, for the line of the launcher and the page of the viewer.
enum class Pace {
  kKeepsUp,
  kBehind,  ///< its longest queue is longer than usual
  kSilent,  ///< it has missed two statuses
  kGone,    ///< it has stopped, or has been silent for so long that it counts as exited
};

/// Returns the pace from the last status of a process: its state, the silence since then, and its longest queue.
Pace PaceOf(std::string_view state, double silent_s, double longest_queue);
std::string_view PaceName(Pace pace);

/// Returns the lag in frames of a process that handles keyframes, behind the newest pose: the frames since the oldest
/// of the `waiting_keyframes` newest keyframes. `is_keyframe(i)` is called for the `n_frames` frames with a pose, the
/// newest (i = 0) first. The lag of that pose behind the player is SentFrames::Behind.
int64_t LagInFrames(int64_t waiting_keyframes, int64_t n_frames, const std::function<bool(int64_t)>& is_keyframe);

}  // namespace plslam
