// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <thread>

#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/loop_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/process/process.h"
#include "loop_process/loop_service.h"
#include "loop_process/node/adjustment_slot.h"
#include "loop_process/node/arrival_queue.h"
#include "loop_process/node/loop_report.h"
#include "loop_process/options.h"

namespace plslam {
class status_t;
}  // namespace plslam

namespace plslam::loop {

/// loop_process on the bus. Inputs: keyframes, the map and relocalisation requests. Outputs: loop closures and
/// relocalisation results.
///
/// One worker checks, in the order of arrival; another runs global bundle adjustments after loops, in parallel. A loop
/// found meanwhile ends the adjustment; the next one starts from its progress. Work waits for a map, which determines
/// the camera in which all arriving features are expressed (`KeyframeInCamera`).
class LoopNode {
 public:
  LoopNode(bus::Process& process, const LoopOptions& options);
  ~LoopNode();
  LoopNode(const LoopNode&) = delete;
  LoopNode& operator=(const LoopNode&) = delete;

 private:
  void OnUpdate(MapUpdate update);
  void OnStatus(const status_t& message);

  // On the workers.
  void CheckUntilStopped();
  void AdjustUntilStopped();
  void Begin(const StereoCamera& camera);
  LoopService::Output Follow(const MapUpdate& update);
  LoopService::Output Handle(const Arrival& arrival);
  void MoveOldToFiles();
  void Send(LoopService::Output output);
  void Count(const LoopClosure& closure);

  bus::Process& process_;
  LoopOptions options_;
  PlaceRecogniser places_;
  bus::LoopClosurePublisher publisher_;
  LoopReport report_;

  // Shared with the workers.
  ArrivalQueue arrivals_;
  AdjustmentSlot adjustments_;

  // Owned by the checking worker.
  StereoCamera map_camera_;
  std::optional<LoopService> service_;
  bool files_failed_ = false;

  std::thread checker_;
  std::thread adjuster_;
  bus::KeyframeSubscriber keyframes_;
  bus::KeyframeSubscriber requests_;
  bus::MapUpdateSubscriber map_;
};

bus::ProcessSpec LoopSpec();

}  // namespace plslam::loop
