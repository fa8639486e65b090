// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/bus/bus.h"
#include "core/ids/ids.h"

namespace plslam::launcher {

/// Content of a run that is over: a reader has to receive all of it.
struct RunContent {
  int64_t n_frames = -1;  ///< that the source has published
  int64_t n_poses = -1;
  KeyframeName keyframe;  ///< newest of the map; number -1: no map is to be awaited
};

/// Publishes begin and end of a run on RUN.
void PublishRunBegin(bus::Bus& bus);
void PublishRunEnd(bus::Bus& bus, const RunContent& content);

}  // namespace plslam::launcher
