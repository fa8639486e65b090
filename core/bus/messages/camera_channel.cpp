// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/camera_channel.h"

#include <spdlog/spdlog.h>

#include <optional>
#include <stdexcept>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/transport/encoded.h"
#include "plslam/camera_t.hpp"

namespace plslam::bus {

struct CameraSubscriber::State {
  Handler handler;
  std::function<void()> on_rejected;
  std::vector<uint8_t> bytes;

  void Take(const camera_t& message) {
    std::vector<uint8_t> heard = RigBytes(message);
    if (heard == bytes) return;
    bytes = std::move(heard);
    const std::optional<RigCalibration> rig = FromMessage(message);
    if (rig) return handler(*rig);
    spdlog::error("the camera '{}' has values that cannot be: it is not used", message.rig_name);
    if (on_rejected) on_rejected();
  }
};

CameraSubscriber::CameraSubscriber(Bus& bus, Handler handler, std::function<void()> on_rejected)
    : state_(std::make_shared<State>(State{std::move(handler), std::move(on_rejected), {}})) {
  bus.Subscribe<camera_t>(kCamera, [weak = std::weak_ptr<State>(state_)](const camera_t& message) {
    if (const auto state = weak.lock()) state->Take(message);
  });
}

const std::vector<uint8_t>& CameraSubscriber::bytes() const { return state_->bytes; }

void CameraSubscriber::Restore(const std::vector<uint8_t>& bytes) {
  const auto message = Decoded<camera_t>(bytes);
  if (!message) throw std::runtime_error("the camera in it is damaged");
  state_->Take(*message);
}

}  // namespace plslam::bus
