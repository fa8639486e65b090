// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tools/calibration/board.h"
#include "tools/calibration/live/live_rig.h"

namespace plslam::calibration {

/// Folder and duration of live pictures.
struct LiveOptions {
  std::string folder;    ///< of pictures, in left and right; must be empty
  std::string page;      ///< HTML file beside the folder
  double seconds = 0.0;  ///< limit, from the first image on; 0: no limit
};

/// Starts the process `camera` on a separate bus, and takes pictures of the board until no view is missing, the source
/// ends, the time is over, or Ctrl-C. Prints a line for each, and the faults of a board that gives no pictures. A
/// failure after the first picture (an unplugged camera, a full disk) is printed as a warning and ends it like Ctrl-C;
/// throws std::runtime_error with the reason if no picture was taken.
void TakeLivePictures(const Board& board, const LiveRigFile& rig, const LiveOptions& options);

}  // namespace plslam::calibration
