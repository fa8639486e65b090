// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/run_end.h"

namespace plslam::viewer {
namespace {

/// Poses arrive in order: with that of the last frame all have arrived, and others were lost before the tracker.
bool HasAllPoses(const Recorder& recorder) {
  return recorder.IsComplete() || recorder.frames().Find(*recorder.n_frames() - 1);
}

}  // namespace

void RunEnd::OnEnd(const Announced& announced) {
  announced_ = announced;
  state_ = State::kAnnounced;
}

void RunEnd::OnNewStream() {
  if (state_ == State::kAnnounced) BeginRun();
}

bool RunEnd::HasMap(const Recorder& recorder, const NewestKeyframes& map) const {
  if (!has_mapper_) return true;
  const auto last = recorder.LastKeyframe();
  return !last || map.HasCommitted(*last);
}

bool RunEnd::IsOver(const Recorder& recorder, const NewestKeyframes& map, const Received& received,
                    std::chrono::milliseconds silence) const {
  if (!recorder.n_frames() || state_ == State::kAwaited) return false;
  if (silence > kSilence) return true;
  if (!received.has_rig || received.surfaces_may_come) return false;
  if (state_ == State::kByHand) {
    return HasAllPoses(recorder) && HasMap(recorder, map) && !received.pictures_may_come;
  }
  return static_cast<int64_t>(recorder.frames().size()) >= announced_.n_poses &&
         map.HasCommitted(announced_.keyframe);
}

}  // namespace plslam::viewer
