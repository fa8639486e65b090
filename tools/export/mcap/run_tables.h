// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/io/trajectories/trajectory.h"
#include "core/ros/ros_messages.h"

namespace plslam::exports {

/// Tables in the folder of a run besides its trajectory; missing ones are empty.
struct RunTables {
  Trajectory live;
  Trajectory truth;
  /// Covariances by time. Motion covariances have the time of the later frame.
  std::map<int64_t, Matrix6d> covariances;
  std::map<int64_t, Matrix6d> motion_covariances;
  /// A row of poses.csv each: state, counts and stage times of a frame.
  std::vector<RosDiagnostic> frames;
};

/// Throws std::runtime_error with file and line.
RunTables ReadRunTables(const std::string& folder);

}  // namespace plslam::exports
