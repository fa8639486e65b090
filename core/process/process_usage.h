// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam::bus {

/// What this process has used so far.
struct Usage {
  double cpu_s = 0.0;      ///< user and system time of all threads
  double memory_mb = 0.0;  ///< resident now
};
Usage CurrentUsage();

std::string HostName();

}  // namespace plslam::bus
