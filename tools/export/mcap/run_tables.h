// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/io/trajectories/trajectory.h"
#include "tools/export/mcap/ros_messages.h"

namespace plslam::exports {

/// What the folder of a run has besides its trajectory; what is not there is empty.
struct RunTables {
  Trajectory live;
  Trajectory truth;
  /// By time. Those of motions stand at the time of the later frame.
  std::map<int64_t, Matrix6d> covariances;
  std::map<int64_t, Matrix6d> motion_covariances;
  /// A row of poses.csv each: state, counts and stage times of a frame.
  std::vector<RosDiagnostic> frames;
};

/// Throws std::runtime_error with file and line.
RunTables ReadRunTables(const std::string& folder);

}  // namespace plslam::exports
