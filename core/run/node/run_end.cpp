// SPDX-License-Identifier: BSD-3-Clause
#include "core/run/node/run_end.h"

#include "core/run/process_names.h"
#include "plslam/run_t.hpp"

namespace plslam {

bool RunEnd::OnRun(const run_t& message) {
  if (message.event == run_event::kBegin) {
    state_ = State::kAwaited;
  } else if (message.event == run_event::kEnd) {
    announced_ = {message.n_poses, {SessionId(message.session), message.session_keyframe_id}};
    state_ = State::kAnnounced;
  } else {
    return false;
  }
  return true;
}

void RunEnd::OnStream(bool ended) {
  stream_ended_ = ended;
  OnMessage();
}

void RunEnd::OnNewStream() {
  stream_ended_ = false;
  if (state_ == State::kAnnounced) BeginRun();
}

bool RunEnd::HasAll(const Received& received, const NewestKeyframes& map) const {
  if (!received.has_rig || received.more_may_come) return false;
  if (state_ == State::kAnnounced)
    return received.n_poses.value_or(announced_.n_poses) >= announced_.n_poses &&
           map.HasCommitted(announced_.keyframe);
  return received.is_tracked && (!has_mapper_ || !received.keyframe || map.HasCommitted(*received.keyframe));
}

bool RunEnd::IsOver(const Received& received, const NewestKeyframes& map) const {
  if (!stream_ended_ || state_ == State::kAwaited || quiet_ticks_ <= 1) return false;
  return HasAll(received, map) || quiet_ticks_ * kTick > kSilence;
}

}  // namespace plslam
