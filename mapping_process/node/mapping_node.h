// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/loop_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/process/process.h"
#include "mapping_process/mapper.h"
#include "mapping_process/node/work_queue.h"
#include "mapping_process/options.h"

namespace plslam {
class command_t;
class status_t;
}  // namespace plslam

namespace plslam::mapping {

/// mapping_process on the bus: keyframes and what loop_process says of them in, updates of the map out.
///
/// A worker owns the map, and takes from a queue what is to be done next (`WorkQueue`). A solve of a live stream ends
/// early when a keyframe comes; of a lockstep stream each is adjusted to the end. Keyframes wait until a camera is heard
/// of. Each comes with the camera that saw it, and is told in that of the map (`ToldIn`), which is that of its first
/// keyframe.
///
/// Now and then, and before each new session, the state is written beside (`state_file`): one that is started again
/// goes on exactly from there, takes from the histories of the others what came after, and so comes to the same map,
/// of a lockstep stream bit for bit.
///
/// A saved map is read at the start, or by order; its keyframes are sent as if a tracker did, for listeners that need
/// their features. Where another map takes the place of the one before ("load", "reset"), trackers begin new sessions,
/// and keyframes of those before are left.
class MappingNode {
 public:
  MappingNode(bus::Process& process, const MappingOptions& options);
  ~MappingNode();
  MappingNode(const MappingNode&) = delete;
  MappingNode& operator=(const MappingNode&) = delete;

 private:
  using Work = WorkQueue::Work;
  using Stages = std::vector<std::pair<std::string, double>>;

  void ReadState();
  void Know(const StoredMap& stored);
  void OnCamera(const RigCalibration& rig);
  void OnKeyframe(const Keyframe& keyframe);
  void OnClosure(const LoopClosure& closure);
  void OnStatus(const status_t& message);
  void OnCommand(const command_t& message);
  void OnTick();
  template <class Change>
  void Queue(const Change& change);

  // On the worker.
  void WorkUntilStopped();
  std::optional<Work> NextWork();
  void BeginMap();
  void GoOnFromState();
  void PublishKeyframes();
  void TellOfMap(const std::string& file);
  void AwaitHistories();
  void Do(const Work& work);
  void Insert(const std::vector<WorkQueue::Arrived>& batch);
  bool InsertOne(const Keyframe& keyframe, std::string* reason);
  void WarnOfMissing(const WorkQueue::Arrived& arrived);
  void Correct(const Work& work);
  LoopClosure OfThisMap(const Work& work) const;
  void Obey(const bus::Order& order);
  void Save(const std::string& path);
  void Replace(MapperState next, const StereoCamera& camera);
  void SetLocaliseOnly(const std::string& argument);
  void KeepState();
  void LeaveOldInFiles();
  void Answer(const LoopClosure& loop, bool accepted);
  void Publish(Stages stage_ms);
  void PublishWhole();
  void CountMap();
  void CountFailures();

  bus::Process& process_;
  MappingOptions options_;
  bus::MapUpdatePublisher publisher_;

  // On the thread of the bus.
  int64_t n_other_map_ = 0;

  // Shared with the worker.
  std::mutex mutex_;
  std::condition_variable changed_;
  WorkQueue queue_;
  /// As of the mapper: keyframes that are meant for another map are left.
  int64_t began_version_ = 0;
  /// What the map begins with.
  std::optional<StereoCamera> camera_;
  bool stopping_ = false;
  /// When the last keyframe or closure came; the start, before that.
  double arrived_ms_;
  std::atomic<bool> stop_solve_{false};

  // The worker's.
  std::optional<StoredMap> stored_;
  std::optional<MapperState> state_;  ///< of one that has crashed
  bool restored_ = false;             ///< there was one
  StateFile state_file_;
  std::optional<Mapper> mapper_;
  LoopAnswer answer_;
  int64_t n_ignored_ = 0;
  int64_t n_missing_ = 0;
  int64_t n_failed_ = 0;
  int64_t n_states_ = 0;
  bool state_failed_ = false;
  int n_since_files_ = 0;  ///< keyframes, since old ones were left in files
  bool files_failed_ = false;
  std::thread worker_;
  bus::CameraSubscriber camera_channel_;
  bus::KeyframeSubscriber keyframes_;
  std::unique_ptr<bus::LoopClosureSubscriber> closures_;
};

bus::ProcessSpec MappingSpec();

}  // namespace plslam::mapping
