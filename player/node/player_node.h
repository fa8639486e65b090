// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/process/process.h"
#include "core/stream/node/frame_sender.h"
#include "player/options.h"

namespace plslam::player {

/// Plays a dataset onto the bus (FrameSender).
class PlayerNode {
 public:
  /// Throws where the dataset cannot be opened.
  PlayerNode(bus::Process& process, const PlayerOptions& options);

 private:
  stream::FrameSender sender_;
};

}  // namespace plslam::player
