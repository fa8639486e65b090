// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/lag.h"

#include "core/run/process_names.h"

namespace plslam {
namespace {

// A queue length worth reporting; a status arrives every second.
constexpr double kReportAbove = 5.0;
constexpr double kSilent_s = 2.5;

}  // namespace

Pace PaceOf(std::string_view state, double silent_s, double longest_queue) {
  if (silent_s > kGoneAfter_s || state == process_state::kStopping) return Pace::kGone;
  if (silent_s > kSilent_s) return Pace::kSilent;
  return longest_queue >= kReportAbove ? Pace::kBehind : Pace::kKeepsUp;
}

std::string_view PaceName(Pace pace) {
  switch (pace) {
    case Pace::kKeepsUp:
      return "keeps up";
    case Pace::kBehind:
      return "behind";
    case Pace::kSilent:
      return "silent";
    case Pace::kGone:
      return "gone";
  }
  return "";
}

int64_t LagInFrames(int64_t waiting_keyframes, int64_t n_frames, const std::function<bool(int64_t)>& is_keyframe) {
  int64_t since_oldest = 0;
  for (int64_t i = 0; i < n_frames && waiting_keyframes > 0; ++i) {
    if (!is_keyframe(i)) continue;
    since_oldest = i + 1;
    --waiting_keyframes;
  }
  return since_oldest;
}

}  // namespace plslam
