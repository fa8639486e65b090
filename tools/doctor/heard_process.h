// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/ids/ids.h"
#include "tools/doctor/finding.h"

namespace plslam::doctor {

/// How a message is signed, seen from here.
enum class Signature {
  kNone,       ///< not at all
  kGood,       ///< with our key
  kUnchecked,  ///< with a key, and we have none
  kWrong,      ///< with another key than ours
};

/// A process whose status was received.
struct HeardProcess {
  std::string prefix;
  std::string process;
  std::string host;
  int64_t pid = 0;
  std::string version;
  std::string state;
  std::string reason;
  SourceId source;
  int schema = 0;
  Signature signature = Signature::kNone;
  std::map<std::string, double> counters;
  /// Its wall clock minus ours, if it publishes its time (the counter `clock.utc_s`).
  std::optional<double> clock_ahead_s;
};

/// Messages received during a few seconds of listening to all channels.
struct Heard {
  std::vector<HeardProcess> processes;
  /// Messages on plslam channels whose type differs from that of this build, by channel with prefix.
  std::map<std::string, int64_t> foreign_types;
  /// Messages on other channels (other users of the bus).
  int64_t other_channels = 0;
};

/// Bus, version and name of the checking host.
struct OwnSide {
  std::string url;
  std::string prefix;
  std::string version;
  std::string host;
  int schema = 0;
  bool has_key = false;
};

/// Returns the reasons why the received processes cannot work with each other or with this host.
Findings CheckProcesses(const Heard& heard, const OwnSide& own);

}  // namespace plslam::doctor
