// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tools/doctor/finding.h"

namespace plslam::doctor {

/// The clocks of this host at one moment.
struct ClockSample {
  int64_t wall_ns = 0;    ///< time of day, comparable between hosts
  int64_t steady_ns = 0;  ///< never set or disciplined
};

ClockSample SampleClocks();

/// Returns whether the kernel reports that the wall clock is synchronised (NTP, PTP).
bool ClockIsSynchronised();

/// Checks the clock between two samples: synchronised, and at the rate of the steady clock.
Findings CheckClock(const ClockSample& begin, const ClockSample& end, bool synchronised);

/// Checks whether files can be written to `folder` (or to its future parent), and how much of them. `use` is their
/// purpose ("histories", "outputs"), `mend` how to choose another folder.
Findings CheckFolder(const std::filesystem::path& folder, const std::string& use, const std::string& mend);

/// Checks whether loop_process finds the vocabulary `name` (of `kind`, "points" or "lines"), and it is complete. `key`:
/// the option that names it.
Findings CheckVocabulary(const std::string& name, const std::string& kind, const std::string& key);

/// Checks whether the programs of the system are beside this one.
Findings CheckPrograms();

}  // namespace plslam::doctor
