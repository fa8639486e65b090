// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/ids/ids.h"

namespace plslam::bus {

/// A process as its status describes it.
struct ProcessIdentity {
  SourceId source;
  std::string host;
  int64_t pid = 0;
  double uptime_s = 0.0;
  /// When it started, by the clock of its host.
  double started_utc_s = 0.0;
};

/// Decides which of several processes of one name, prefix and bus may run: the one that has run longest. The others
/// yield, because two trackers or two maps that publish to the same readers give a mixture of both.
///
/// Input: the statuses of the others. A process that has exited may have left a last status on the way, so only a
/// second one, later than the first and by as much older, proves that it runs (repeated copies of a message do not).
/// Running processes answer a new one at once (`kReply`), so a starting process knows within `kStartWindow_s` whether it
/// is alone. A value without clock and bus.
class NamesakeWatch {
 public:
  /// How long a starting process waits for namesakes before it does anything else.
  static constexpr double kStartWindow_s = 0.25;
  /// Least time between the two statuses that prove that a namesake runs: at the start, and later.
  static constexpr double kStartProof_s = 0.08;
  static constexpr double kProof_s = 1.5;
  /// Uptimes that differ by more decide; otherwise the times of the start do.
  static constexpr double kSameUptime_s = 2.0;
  /// A younger namesake that still publishes after this time does not yield: a log is being replayed.
  static constexpr double kPatience_s = 5.0;

  enum class Action {
    kNone,
    kReply,   ///< publish a status now: the namesake has just started
    kYield,   ///< stop: the namesake is older
    kReport,  ///< report it, once: the namesake should have yielded
  };

  explicit NamesakeWatch(SourceId own_source) : own_source_(own_source) {}

  /// `now_s`: steady time. `own`: this process, now.
  Action OnStatus(const ProcessIdentity& other, const ProcessIdentity& own, double now_s);

  /// "another vo is running on this bus: process 17 on robot, for 12 s".
  static std::string Sentence(const std::string& process, const ProcessIdentity& other);

 private:
  struct Seen {
    double first_s = 0.0;
    double first_uptime_s = 0.0;
    bool is_reported = false;
  };

  SourceId own_source_;
  std::map<SourceId, Seen> seen_;  // by source
};

}  // namespace plslam::bus
