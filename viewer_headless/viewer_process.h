// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/process/process.h"

namespace plslam::viewer {

/// The process: options on the command line over those of the configuration.
bus::ProcessSpec ViewerProcess();

}  // namespace plslam::viewer
