// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tools/calibration/board.h"
#include "tools/calibration/live/live_rig.h"

namespace plslam::calibration {

/// Where live pictures go, and how long they are taken.
struct LiveOptions {
  std::string folder;    ///< of pictures, in left and right; has none yet
  std::string page;      ///< HTML, beside the folder
  double seconds = 0.0;  ///< at most, from the first image on; 0: no limit
};

/// Starts the process `camera` on a bus of its own, and takes pictures of the board until no view is missing, the
/// source ends, the time is over, or Ctrl-C. Prints a line for each, and what is wrong with the board where it gives
/// none. A failure after the first picture (an unplugged camera, a full disk) is printed as a warning and ends it like
/// Ctrl-C; throws std::runtime_error that says why where no picture was taken.
void TakeLivePictures(const Board& board, const LiveRigFile& rig, const LiveOptions& options);

}  // namespace plslam::calibration
