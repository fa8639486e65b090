// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/map/map.h"

namespace plslam::viewer {

/// What an LCM log has of a run besides the files that it gives.
struct LoggedRun {
  /// As it was at the end of the log; without keyframes where the log has no map.
  Map map;
  /// The log has stereo frames, so that it can be played.
  bool has_frames = false;
  /// What the log lacks, in a sentence; empty where nothing is missing.
  std::string lack;
};

/// Writes the files that viewer_headless would have written of the run that an LCM log holds (`plslam run --record`,
/// `plslam record`, lcm-logger): its poses, map and true poses, with the code that it has for that. Channels may have a
/// prefix: of several robots the one with the most poses counts.
///
/// Throws std::runtime_error in one sentence where the log has no run in it, and names `plslam replay` where it has
/// the frames to compute one from.
LoggedRun WriteLoggedRun(const std::string& log, const std::string& folder);

}  // namespace plslam::viewer
