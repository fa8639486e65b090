// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam::bus {

/// Keeps the freed memory of frames in the process from now on. If it were returned to the kernel for each frame, it
/// would be cleared, page by page, for the next one: that is a sixth of all page faults of a run at 752x480, a third at
/// 1241x376.
void KeepFreedMemory();

/// Returns to the kernel the memory that this thread has freed, and of other threads the memory between blocks in use:
/// for calls after rare work that took much memory.
void GiveBackFreedMemory();

/// CPU time and memory of this process so far.
struct Usage {
  double cpu_s = 0.0;      ///< user and system time of all threads
  double memory_mb = 0.0;  ///< resident now
};
Usage CurrentUsage();

/// Largest resident memory of this process so far.
double PeakMemory_mb();

std::string HostName();

}  // namespace plslam::bus
