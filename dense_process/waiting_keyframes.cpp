// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/waiting_keyframes.h"

#include <algorithm>
#include <utility>

namespace plslam::dense {
namespace {

template <class Value>
void KeepNewest(std::map<FrameId, Value>& values) {
  while (values.size() > WaitingKeyframes::kMostFrames) values.erase(values.begin());
}

/// Returns the value of a frame, which stays: a keyframe of another session may have the same frame.
template <class Value>
Value Find(const std::map<FrameId, Value>& values, FrameId frame_id) {
  const auto found = values.find(frame_id);
  return found == values.end() ? Value() : found->second;
}

}  // namespace

bool WaitingKeyframes::AddImages(const StereoImages& images) {
  for (auto& [name, waiting] : keyframes_) {
    const Keyframe& keyframe = waiting.keyframe;
    if (!waiting.images && keyframe.frame_id == images.frame_id && keyframe.t_ns == images.t_ns) {
      waiting.images = images;
      return true;
    }
  }
  frames_[images.frame_id] = images;
  KeepNewest(frames_);
  return false;
}

void WaitingKeyframes::AddBodies(FrameId frame_id, BodyPixels bodies) {
  bodies_[frame_id] = std::move(bodies);
  KeepNewest(bodies_);
}

void WaitingKeyframes::AddMask(FrameId frame_id, const FrameMask& mask) {
  masks_[frame_id] = mask;
  KeepNewest(masks_);
}

void WaitingKeyframes::Add(const Keyframe& keyframe) {
  Waiting waiting{keyframe, std::nullopt};
  const auto frame = frames_.find(keyframe.frame_id);
  if (frame != frames_.end() && frame->second.t_ns == keyframe.t_ns) {
    waiting.images = std::move(frame->second);
    frames_.erase(frame);
  }
  keyframes_.insert_or_assign({keyframe.name.session, keyframe.frame_id}, std::move(waiting));
  DropOldest();
}

/// Keyframes that were made before this process started have no images. In lockstep all others stay: they wait for the
/// map alone, and the results of a run do not depend on its times.
void WaitingKeyframes::DropOldest() {
  while (keyframes_.size() > kMostWaiting) {
    auto dropped = std::ranges::find_if(keyframes_, [](const auto& w) { return !w.second.images.has_value(); });
    const bool lacks = dropped != keyframes_.end();
    if (!lacks) dropped = std::ranges::find_if(keyframes_, [](const auto& w) { return !w.second.keyframe.lockstep; });
    if (dropped == keyframes_.end()) return;
    ++(lacks ? n_without_images_ : n_dropped_);
    keyframes_.erase(dropped);
  }
}

std::vector<ReadyKeyframe> WaitingKeyframes::Take(const std::function<bool(const Keyframe&)>& is_placed) {
  std::vector<ReadyKeyframe> ready;
  for (auto it = keyframes_.begin(); it != keyframes_.end();) {
    Waiting& waiting = it->second;
    if (!waiting.images || !is_placed(waiting.keyframe)) {
      ++it;
      continue;
    }
    const FrameId frame_id = waiting.keyframe.frame_id;
    ready.push_back(
        {std::move(waiting.keyframe), *std::move(waiting.images), Find(masks_, frame_id), Find(bodies_, frame_id)});
    it = keyframes_.erase(it);
  }
  return ready;
}

}  // namespace plslam::dense
