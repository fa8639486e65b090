// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "tools/doctor/finding.h"

namespace plslam {

/// The clocks of this host at one moment.
struct ClockSample {
  int64_t wall_ns = 0;    ///< what people and other hosts call the time
  int64_t steady_ns = 0;  ///< never set, disciplined by nobody
};

ClockSample SampleClocks();

/// Whether the kernel says that something (NTP, PTP) keeps the wall clock right.
bool ClockIsSynchronised();

/// The clock between two samples: kept by somebody, and at one pace with the steady clock.
Findings CheckClock(const ClockSample& begin, const ClockSample& end, bool synchronised);

}  // namespace plslam
