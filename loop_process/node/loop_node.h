// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/loop_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/process/process.h"
#include "loop_process/loop_service.h"
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
  struct RelocalisationRequest {
    Keyframe frame;
  };
  struct SignOfLife {
    SourceId source;
  };
  using Arrival = std::variant<Keyframe, MapUpdate, RelocalisationRequest, SignOfLife, LoopClosure>;

  void OnUpdate(MapUpdate update);
  void OnStatus(const status_t& message);
  void Queue(Arrival arrival);
  /// `more` is 1 for an arrival that is queued, -1 for one that leaves the queue.
  void CountWaiting(const Arrival& arrival, int more);

  // On the workers.
  void CheckUntilStopped();
  void AdjustUntilStopped();
  void Begin(const StereoCamera& camera);
  LoopService::Output Follow(const MapUpdate& update);
  LoopService::Output Handle(const Arrival& arrival);
  void MoveOldToFiles();
  void DropAdjustment(bool with_progress);
  void Send(LoopService::Output output);
  void Count(const LoopClosure& closure);
  void CountFailure(const std::string& failure);

  bus::Process& process_;
  LoopOptions options_;
  PlaceRecogniser places_;
  bus::LoopClosurePublisher publisher_;
  bool has_camera_ = false;  // on the thread of the bus

  // Shared with the workers.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Arrival> arrivals_;        ///< bounded: see `Queue`
  int64_t n_waiting_keyframes_ = 0;     ///< among the arrivals
  std::optional<StereoCamera> camera_;  ///< of the first map
  std::optional<GlobalBundleProblem> adjustment_;
  bool stopping_ = false;
  std::atomic<bool> stop_adjustment_{false};
  bool forgets_progress_ = false;  ///< the next adjustment starts without the progress of earlier ones
  int64_t n_dropped_ = 0;          ///< adjustments, running or queued, that a later loop made obsolete

  // Owned by the checking worker.
  StereoCamera map_camera_;
  std::optional<LoopService> service_;
  bool files_failed_ = false;
  int64_t n_loops_ = 0;
  int64_t n_answers_ = 0;
  int64_t n_found_ = 0;
  int64_t n_failed_ = 0;  // owned by the adjusting worker
  std::thread checker_;
  std::thread adjuster_;
  bus::KeyframeSubscriber keyframes_;
  bus::KeyframeSubscriber requests_;
  bus::MapUpdateSubscriber map_;
};

bus::ProcessSpec LoopSpec();

}  // namespace plslam::loop
