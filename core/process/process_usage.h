// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam::bus {

/// Frames come and go: from now on their memory stays with the process. Given back to the kernel at each, it would be
/// cleared, page by page, for the next: of all page faults of a run that is a sixth at 752x480, a third at 1241x376.
void KeepFreedMemory();

/// Gives back what this thread has freed, and of other threads what lies between blocks still in use: after work that
/// took much memory and comes seldom.
void GiveBackFreedMemory();

/// What this process has used so far.
struct Usage {
  double cpu_s = 0.0;      ///< user and system time of all threads
  double memory_mb = 0.0;  ///< resident now
};
Usage CurrentUsage();

std::string HostName();

}  // namespace plslam::bus
