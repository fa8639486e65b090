// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/messages/grid_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/bus/messages/submap_channel.h"
#include "core/robot/node/pose_steps.h"
#include "core/ros/live_messages.h"

namespace plslam {
class pose_t;
class status_t;
}  // namespace plslam

namespace plslam::bus {

/// Listens to the run on the bus and writes the live topics of the table: poses as they arrive, images if they are
/// wanted, map, surfaces, grid and path at most once a second after changes. On the thread of `Bus::Run`.
class LiveRun {
 public:
  /// `wants_images` is called on the receiving thread of the bus: it must be quick, and safe there.
  LiveRun(Bus& bus, LiveMessages messages, std::function<bool()> wants_images);

 private:
  void OnPose(const pose_t& message);
  void OnStatus(const status_t& message);
  void Tick();

  Bus& bus_;
  LiveMessages messages_;
  robot::PoseSteps steps_;
  bool has_new_poses_ = false;
  bool has_new_map_ = false;
  bool has_new_grid_ = false;
  bool has_new_surfaces_ = false;
  MapSubscriber map_;
  GridSubscriber grid_;
  SubmapSubscriber surfaces_;
  CameraSubscriber camera_;
  FrameSubscriber frames_;
};

}  // namespace plslam::bus
