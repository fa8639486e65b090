// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/waiting_keyframes.h"

#include <algorithm>
#include <utility>

namespace plslam::dense {

/// The frame with this name, in place of the oldest one if it is new.
WaitingKeyframes::Frame& WaitingKeyframes::FrameOf(const FrameName& name) {
  const auto found = std::ranges::find(frames_, name, &Frame::name);
  if (found != frames_.end()) return *found;
  if (frames_.size() >= kMostFrames) frames_.pop_front();
  Frame& frame = frames_.emplace_back();
  frame.name = name;
  return frame;
}

/// Sets what was received of a frame, also in keyframes that wait: those of several sessions may have the same frame.
/// Returns whether there are any.
template <class Set>
bool WaitingKeyframes::ForEach(const FrameName& name, const Set& set) {
  set(FrameOf(name));
  bool waits = false;
  for (auto& [keyframe_name, waiting] : keyframes_) {
    if (waiting.frame.name != name) continue;
    set(waiting.frame);
    waits = true;
  }
  return waits;
}

bool WaitingKeyframes::AddImages(const StereoImages& images) {
  return ForEach({images.frame_id, images.t_ns}, [&](Frame& frame) { frame.images = images; });
}

bool WaitingKeyframes::AddBodies(const FrameName& name, const BodyPixels& bodies) {
  return ForEach(name, [&](Frame& frame) { frame.bodies = bodies; });
}

void WaitingKeyframes::AddMask(const FrameName& name, const FrameMask& mask) {
  ForEach(name, [&](Frame& frame) { frame.mask = mask; });
}

void WaitingKeyframes::Add(const Keyframe& keyframe) {
  Waiting waiting{keyframe, {{keyframe.frame_id, keyframe.t_ns}, {}, {}, {}}};
  const auto found = std::ranges::find(frames_, waiting.frame.name, &Frame::name);
  if (found != frames_.end()) waiting.frame = *found;
  keyframes_.insert_or_assign({keyframe.name.session, keyframe.frame_id}, std::move(waiting));
  DropOldest();
}

/// Images of keyframes that were made before this process started are not sent again. In lockstep all others stay: they wait for the
/// map alone, and the results of a run do not depend on its times.
void WaitingKeyframes::DropOldest() {
  while (keyframes_.size() > kMostWaiting) {
    auto dropped = std::ranges::find_if(keyframes_, [](const auto& w) { return !w.second.frame.IsComplete(); });
    const bool lacks = dropped != keyframes_.end();
    if (!lacks) dropped = std::ranges::find_if(keyframes_, [](const auto& w) { return !w.second.keyframe.lockstep; });
    if (dropped == keyframes_.end()) return;
    ++(lacks ? n_incomplete_ : n_dropped_);
    keyframes_.erase(dropped);
  }
}

bool WaitingKeyframes::HasComplete() const {
  return std::ranges::any_of(keyframes_, [](const auto& waiting) { return waiting.second.frame.IsComplete(); });
}

std::vector<ReadyKeyframe> WaitingKeyframes::Take(const std::function<bool(const Keyframe&)>& is_placed) {
  std::vector<ReadyKeyframe> ready;
  for (auto it = keyframes_.begin(); it != keyframes_.end();) {
    Waiting& waiting = it->second;
    Frame& frame = waiting.frame;
    if (!frame.IsComplete() || !is_placed(waiting.keyframe)) {
      ++it;
      continue;
    }
    ready.push_back(
        {std::move(waiting.keyframe), *std::move(frame.images), std::move(frame.mask), *std::move(frame.bodies)});
    it = keyframes_.erase(it);
  }
  return ready;
}

}  // namespace plslam::dense
