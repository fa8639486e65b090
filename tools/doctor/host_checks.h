// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tools/doctor/finding.h"

namespace plslam::doctor {

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

/// Whether files can be written to `folder` (or to where it will be made), and how much of them. `use` says what for
/// ("histories", "outputs"), `mend` how to choose another folder.
Findings CheckFolder(const std::filesystem::path& folder, const std::string& use, const std::string& mend);

/// Whether the vocabulary `name` (of `kind`, "points" or "lines") is where loop_process looks for it, and whole.
/// `key`: the option that names it.
Findings CheckVocabulary(const std::string& name, const std::string& kind, const std::string& key);

/// Whether the programs of the system stand beside this one.
Findings CheckPrograms();

}  // namespace plslam::doctor
