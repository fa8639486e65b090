// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/loop_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/ids/ids.h"
#include "core/process/process.h"
#include "mapping_process/mapper.h"
#include "mapping_process/node/map_counters.h"
#include "mapping_process/node/map_membership.h"
#include "mapping_process/node/map_on_disk.h"
#include "mapping_process/node/work_queue.h"
#include "mapping_process/options.h"

namespace plslam {
class command_t;
class status_t;
}  // namespace plslam

namespace plslam::mapping {

/// mapping_process on the bus. Inputs: keyframes, loop closures, commands. Output: map updates.
///
/// A worker owns the map and takes its next task from a queue (`WorkQueue`). A solve of a live session ends early when
/// a keyframe arrives; in lockstep each runs to the end. Keyframes wait until a camera is known. Each comes with its
/// own camera, and is re-expressed in that of the map (`KeyframeInCamera`), which is that of its first keyframe.
///
/// The state is written periodically, before each new session, and at an orderly stop (`state_file`): a process started
/// later continues exactly from there, takes later messages from the histories of other processes, and so reaches the
/// same map, in lockstep bit for bit. "reset" or a missing file begins a new map. Without a state, or with an unreadable
/// one, the map is rebuilt from the histories: the last of those that keyframes in them name.
///
/// A saved map is loaded at the start or by command; its keyframes are published as trackers do, for listeners that
/// need their features. After another map has replaced the current one ("load", "reset"), trackers begin new sessions,
/// and keyframes of earlier sessions are ignored.
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
  void AdoptStored(const StoredMap& stored);
  void AdoptState(const MapperState& state);
  void OnCamera(const RigCalibration& rig);
  void OnKeyframe(const Keyframe& keyframe);
  void Refuse(SessionId session);
  void OnClosure(const LoopClosure& closure);
  void OnStatus(const status_t& message);
  void OnCommand(const command_t& message);
  void OnTick();
  template <class Change>
  void Queue(const Change& change);

  // On the worker.
  void WorkUntilStopped();
  std::optional<Work> NextWork();
  void WorkBeforeStop();
  void BeginMap();
  void RestoreState(MapperState state);
  void PublishKeyframes(const std::optional<std::set<KeyframeId>>& ids = std::nullopt);
  void LogStoredMap(const std::string& file);
  bool MayReplaceAnother() const;
  /// A state file that this version cannot read is kept under this name.
  std::string UnreadableState() const { return options_.state_file + ".unreadable"; }
  void AwaitHistories();
  void Do(const Work& work);
  void Insert(const std::vector<WorkQueue::Arrived>& batch);
  bool InsertOne(const Keyframe& keyframe, std::string* reason);
  void WarnOfMissing(const WorkQueue::Arrived& arrived);
  void Correct(const Work& work);
  LoopClosure InOwnIds(const Work& work) const;
  void Execute(const bus::Order& order);
  void Save(const std::string& argument);
  void Own(Mapper mapper);
  void Replace(MapperState next, const StereoCamera& camera, const std::optional<MapId>& id = std::nullopt);
  void SetLocaliseOnly(const std::string& argument);
  void KeepState();
  void Answer(const LoopClosure& loop, bool accepted);
  bool IsStateDue();
  MapId MapIdNow();
  bool HasRefused();
  void Publish(Stages stage_ms);
  void PublishWhole();

  bus::Process& process_;
  MappingOptions options_;
  bus::MapUpdatePublisher publisher_;

  // Shared with the worker.
  std::mutex mutex_;
  std::condition_variable changed_;
  WorkQueue queue_;
  MapMembership membership_;
  /// Camera with which the map begins.
  std::optional<StereoCamera> camera_;
  bool stopping_ = false;
  /// Time of the last keyframe or closure; the start before that.
  double arrived_ms_;
  std::atomic<bool> stop_solve_{false};

  // Owned by the worker.
  /// An empty map, a saved one, or the state of a previous process; empty after the map has begun with it.
  std::variant<std::monostate, StoredMap, MapperState> beginning_;
  std::optional<Mapper> mapper_;
  LoopAnswer answer_;
  MapCounters counters_;
  MapOnDisk disk_;
  std::thread worker_;
  bus::CameraSubscriber camera_channel_;
  bus::KeyframeSubscriber keyframes_;
  bus::LoopClosureSubscriber closures_;
};

bus::ProcessSpec MappingSpec();

}  // namespace plslam::mapping
