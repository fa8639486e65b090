// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/bus/bus.h"
#include "core/bus/messages/pager.h"
#include "core/map/keyframe.h"
#include "plslam/keyframe_t.hpp"

namespace plslam::bus {

/// `keyframe` as pages of at most `page_bytes`, points before lines. Throws std::invalid_argument where the ids are
/// not as many as the features (ids of the map may be left out altogether).
std::vector<keyframe_t> CutIntoPages(const Keyframe& keyframe, int64_t page_bytes);

/// Puts keyframes together again.
class KeyframeAssembler : public PageAssembler<keyframe_t, Keyframe> {
 public:
  KeyframeAssembler();
};

/// Sends keyframes over `channel`, one of type keyframe_t; `header_t.session` and `t_ns` are taken from the keyframe.
class KeyframePublisher {
 public:
  explicit KeyframePublisher(Bus& bus, const Channel& channel = kKeyframe) : bus_(bus), channel_(channel) {}
  void Publish(const Keyframe& keyframe);

 private:
  Bus& bus_;
  Channel channel_;
};

/// Hands every keyframe of every publisher to `handler`, in order, on the thread of `Bus::Run`. Pages that cannot be
/// are counted in `BusCounters::rejected`.
class KeyframeSubscriber {
 public:
  KeyframeSubscriber(Bus& bus, std::function<void(const Keyframe&)> handler, const Channel& channel = kKeyframe);

 private:
  std::shared_ptr<void> subscription_;
};

}  // namespace plslam::bus
