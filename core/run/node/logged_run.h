// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "core/files/notes.h"
#include "core/map/map.h"
#include "core/run/recorder.h"
#include "core/run/run.h"

namespace plslam {

/// The run that an LCM log holds.
struct LoggedRun {
  /// In front of the channels of the robot.
  std::string prefix;
  Recorder recorder;
  Eigen::Quaterniond q_l_c;  ///< left camera as calibrated (l) from rectified left camera (c)
  /// As it was at the end of the log; without keyframes where the log has no map.
  Map map;
  /// The log has stereo frames of the robot, so that it can be played.
  bool has_frames = false;
  Notes notes;  ///< warnings about missing messages
};

/// Reads a log of `plslam run --record`, `plslam record` or lcm-logger. If there are several robots (prefixes of
/// channels), the one with the most poses is read; of several streams the last one that began, as in viewer_headless.
/// The map may be shared by several robots, under its own prefix.
///
/// Throws std::runtime_error in one sentence if the log has no run, and names `plslam replay` if it has the frames to
/// compute one from.
LoggedRun ReadLoggedRun(const std::string& log);

/// Returns the outputs of the run, as `ReadRun` reads the folder of `WriteLoggedRun`, without the rounding of its files.
/// The map is without features and is there only with its camera.
Run RunOf(const LoggedRun& logged);

/// Writes the files that viewer_headless would have written for it. Throws std::runtime_error.
void WriteLoggedRun(const LoggedRun& run, const std::string& folder);

}  // namespace plslam
