// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/process/process.h"
#include "vo_process/options.h"

namespace plslam::vo {

/// Warns once of each input that arrives although its use is not enabled: masks, and poses of the robot.
void WarnOfUnusedInputs(bus::Process& process, const VoOptions& options);

}  // namespace plslam::vo
