// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/node/live_run.h"

#include <fmt/format.h>

#include <chrono>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/errors/log.h"
#include "core/run/process_names.h"
#include "core/run/tracking_state.h"
#include "plslam/counter_t.hpp"
#include "plslam/pose3_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/stage_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"

namespace plslam::bus {
namespace {

/// The levels of diagnostic_msgs/DiagnosticStatus.
enum DiagnosticLevel { kOk = 0, kWarn = 1, kError = 2 };

DiagnosticLevel LevelOf(std::string_view state) {
  if (state == process_state::kFailed) return kError;
  return state == process_state::kReady || state == process_state::kRunning || state == process_state::kFinished
             ? kOk
             : kWarn;
}

}  // namespace

LiveRun::LiveRun(Bus& bus, LiveMessages messages, std::function<bool()> wants_images)
    : bus_(bus),
      messages_(std::move(messages)),
      map_(bus, [this](const MapUpdate&) { has_new_map_ = true; }),
      grid_(bus, [this] { has_new_grid_ = true; }),
      surfaces_(bus, [this] { has_new_surfaces_ = true; }),
      camera_(bus,
              [this](const RigCalibration& rig) {
                try {
                  messages_.SetRig(rig);
                } catch (const std::runtime_error& error) {
                  LogWarning("the camera cannot be used: {}", error.what());
                }
              }),
      frames_(
          bus, FrameSubscriber::Mode::kPictures,
          [this](const FrameSubscriber::Frame& frame) { messages_.WriteImage(frame.images.t_ns, frame.images.left); },
          [wants_images = std::move(wants_images)](FrameId) { return wants_images(); }) {
  bus_.Subscribe<pose_t>(kPose, [this](const pose_t& message) { OnPose(message); });
  bus_.Subscribe<status_t>(kStatus, [this](const status_t& message) { OnStatus(message); });
  bus_.Subscribe<stream_t>(kStream, [this](const stream_t& message) {
    if (message.event != stream_event::kEnd) camera_.Follow(SourceId(message.header.session));
  });
  bus_.Every(std::chrono::milliseconds(1000), [this] { Tick(); });
}

void LiveRun::OnPose(const pose_t& message) {
  const std::optional<double> dt_s = steps_.SecondsSinceLast(message);
  const auto T_odom_c = FromMessage(message.T_odom_c), T_w_odom = FromMessage(message.T_w_odom),
             T_prev_c = FromMessage(message.T_prev_c);
  const auto covariance = FromArray(message.covariance), motion_covariance = FromArray(message.motion_covariance);
  if (!T_odom_c || !T_w_odom || !T_prev_c || !covariance || !motion_covariance) return bus_.CountRejected();
  // An initialising session has no pose before its first keyframe.
  const bool is_initialising =
      static_cast<TrackingState>(message.state) == TrackingState::kInitialising && message.keyframe_id < 0;
  if (is_initialising) return;
  messages_.AddPose({message.header.t_ns, *T_w_odom, message.anchored != 0, *T_odom_c, *covariance, *T_prev_c,
                     *motion_covariance, dt_s},
                    SessionId(message.header.session));
  has_new_poses_ = true;
}

void LiveRun::OnStatus(const status_t& message) {
  RosDiagnostic diagnostic{
      .level = LevelOf(message.state),
      .name = message.process,
      .message = message.reason.empty() ? message.state : fmt::format("{}: {}", message.state, message.reason),
      .values = {}};
  for (const counter_t& counter : message.counters) {
    diagnostic.values.emplace_back(counter.name, fmt::format("{}", counter.value));
  }
  messages_.WriteDiagnostic(std::move(diagnostic));
}

void LiveRun::Tick() {
  if (std::exchange(has_new_poses_, false)) messages_.WritePath();
  if (!messages_.has_rig()) return;  // a process that starts in a run may receive the map before the rig
  if (std::exchange(has_new_map_, false)) messages_.WriteMap(map_.follower().map());
  if (std::exchange(has_new_grid_, false)) messages_.WriteGrid(grid_.Whole());
  if (std::exchange(has_new_surfaces_, false)) messages_.WriteSurfaces(surfaces_.cloud());
}

}  // namespace plslam::bus
