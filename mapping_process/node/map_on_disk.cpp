// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/node/map_on_disk.h"

#include <exception>
#include <utility>

#include "core/errors/log.h"
#include "core/io/maps/map_camera.h"
#include "core/map/keyframe_features.h"
#include "core/process/process_usage.h"

namespace plslam::mapping {

void MapOnDisk::KeepState(Mapper& mapper, const LoopAnswer& answer, const WorkQueue::Newest& newest) {
  if (!keeps_state_) return;
  try {
    mapper.LendState([&](MapperState& state) {
      state.stored.rig = CameraBytes(mapper.camera());
      state.answer = answer;
      state.lockstep = newest.lockstep ? 1 : 0;
      for (const LoopClosure::Kind kind : newest.taken) state.closures |= 1 << static_cast<int>(kind);
      state_file_.Write(state);
    });
    process_.SetCounter("state.written", static_cast<double>(++n_states_));
  } catch (const std::exception& error) {
    if (!std::exchange(state_failed_, true)) LogWarning("the state for a restart is not written: {}", error.what());
  }
  MoveOldFeatures(mapper);
  bus::GiveBackFreedMemory();
}

void MapOnDisk::Inserted(int count, Mapper& mapper) {
  if ((n_since_move_ += count) >= kFilesEvery) MoveOldFeatures(mapper);
}

void MapOnDisk::MoveOldFeatures(Mapper& mapper) {
  n_since_move_ = 0;
  if (mapper.MoveOldToFiles() || std::exchange(move_failed_, true)) return;
  LogWarning("{}", CannotLeaveMemory());
}

}  // namespace plslam::mapping
