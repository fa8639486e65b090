// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/run_publisher.h"

#include <utility>

#include "core/run/process_names.h"
#include "plslam/run_t.hpp"

namespace plslam::launcher {
namespace {

void Publish(bus::Bus& bus, const char* event, const RunContent& content) {
  run_t message{};
  message.event = event;
  message.n_frames = content.n_frames;
  message.n_poses = content.n_poses;
  message.session = content.keyframe.session.value;
  message.session_keyframe_id = content.keyframe.number;
  bus.Publish(bus::kRun, std::move(message));
}

}  // namespace

void PublishRunBegin(bus::Bus& bus) { Publish(bus, run_event::kBegin, {}); }
void PublishRunEnd(bus::Bus& bus, const RunContent& content) { Publish(bus, run_event::kEnd, content); }

}  // namespace plslam::launcher
