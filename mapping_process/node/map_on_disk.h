// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/map/map_update.h"
#include "core/process/process.h"
#include "mapping_process/mapper.h"
#include "mapping_process/mapper_state.h"
#include "mapping_process/node/work_queue.h"

namespace plslam::mapping {

/// Files that mapping_process writes: its state for a restart, if it has a state file, and features of older
/// keyframes, which leave memory. A failure is reported once, and the process continues, with a higher cost of a crash
/// or of memory.
class MapOnDisk {
 public:
  MapOnDisk(bus::Process& process, const std::string& state_file)
      : process_(process), state_file_(state_file), keeps_state_(!state_file.empty()) {}

  bool keeps_state() const { return keeps_state_; }
  /// Records the changes of the next state.
  void Note(const MapUpdate& update) {
    if (keeps_state_) state_file_.Note(update);
  }
  /// The next state is that of another map.
  void BeginMap() { state_file_.Reset(); }
  /// Writes the state, if there is a file for it. `newest` is the newest keyframe in the map.
  void KeepState(Mapper& mapper, const LoopAnswer& answer, const WorkQueue::Newest& newest);

  /// Moves features after every `kFilesEvery` inserted keyframes.
  void Inserted(int count, Mapper& mapper);
  void MoveOldFeatures(Mapper& mapper);

 private:
  bus::Process& process_;
  StateFile state_file_;
  bool keeps_state_;
  int64_t n_states_ = 0;
  bool state_failed_ = false;
  int n_since_move_ = 0;  ///< keyframes since old features were moved
  bool move_failed_ = false;
};

}  // namespace plslam::mapping
