// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/bus/bus.h"
#include "core/geometry/calibration.h"

namespace plslam::bus {

/// Hears which camera is in use, on the thread of `Bus::Run`.
///
/// A player repeats its camera every second; `handler` gets a rig only when it differs from the one before. A camera
/// with values that cannot be is refused with one line in the log, and `on_rejected` is called; the camera before
/// stays in use.
class CameraSubscriber {
 public:
  using Handler = std::function<void(const RigCalibration& rig)>;

  CameraSubscriber(Bus& bus, Handler handler, std::function<void()> on_rejected = nullptr);

  /// The camera heard last, for `Restore` in a process that is started in this one's place; empty before one was
  /// heard.
  const std::vector<uint8_t>& bytes() const;
  /// Hands on a camera that another process has kept. Throws std::runtime_error where the bytes are damaged.
  void Restore(const std::vector<uint8_t>& bytes);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace plslam::bus
