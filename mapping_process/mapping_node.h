#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/bus/keyframe_channel.h"
#include "core/bus/map_channel.h"
#include "core/bus/process.h"
#include "mapping_process/mapper.h"
#include "mapping_process/options.h"

namespace plslam {
class camera_t;

/// mapping_process on the bus: keyframes in, updates of the map out.
///
/// A worker owns the map. Keyframes queue while it solves; of a live stream all that have queued are inserted before the
/// next solve, and a solve ends early when one comes; of a lockstep stream each is adjusted to the end. Keyframes
/// wait for the camera. The map is of one camera: keyframes of sessions that began with another are counted and left.
class MappingNode {
 public:
  MappingNode(bus::Process& process, const MappingOptions& options);
  ~MappingNode();
  MappingNode(const MappingNode&) = delete;
  MappingNode& operator=(const MappingNode&) = delete;

 private:
  struct Queued {
    Keyframe keyframe;
    double received_ms = 0.0;
  };

  void OnCamera(const camera_t& message);
  void OnKeyframe(const Keyframe& keyframe);
  void OnAsked();

  // On the worker.
  void Work();
  void WorkUntilStopped();
  std::vector<Queued> TakeQueued();
  void Map(const std::vector<Queued>& batch);
  void Report(const MapUpdate& update);

  bus::Process& process_;
  MappingOptions options_;
  bus::MapUpdatePublisher publisher_;

  // On the thread of the bus.
  std::vector<uint8_t> camera_bytes_;
  bool other_camera_ = false;
  std::set<int64_t> known_sessions_;
  int64_t n_other_camera_ = 0;

  // Shared with the worker.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Queued> queue_;
  std::optional<StereoCamera> camera_;
  bool asked_ = false;
  bool stopping_ = false;
  std::atomic<bool> stop_solve_{false};

  std::optional<Mapper> mapper_;  // the worker's
  int64_t n_ignored_ = 0;
  std::thread worker_;
  bus::KeyframeSubscriber keyframes_;
};

bus::ProcessSpec MappingSpec();

}  // namespace plslam
