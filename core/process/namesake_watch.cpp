// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/namesake_watch.h"

#include <fmt/format.h>

#include <cmath>
#include <tuple>

namespace plslam::bus {
namespace {

// Sources are not limited: anybody can invent some.
constexpr size_t kMaxNamesakes = 64;

/// Both sides come to the same result: numbers that depend on the delay of a message only decide where they differ
/// clearly.
bool IsOlder(const ProcessIdentity& a, const ProcessIdentity& b) {
  if (std::abs(a.uptime_s - b.uptime_s) > NamesakeWatch::kSameUptime_s) return a.uptime_s > b.uptime_s;
  return std::tie(a.started_utc_s, a.source) < std::tie(b.started_utc_s, b.source);
}

/// Whether the uptime of a process has grown with the time, as far as messages are in time.
bool RunsFor(double time_s, double uptime_s) { return std::abs(uptime_s - time_s) < 0.02 + 0.3 * time_s; }

NamesakeWatch::Action Reply(const ProcessIdentity& starting) {
  return starting.uptime_s < NamesakeWatch::kSameUptime_s ? NamesakeWatch::Action::kReply
                                                          : NamesakeWatch::Action::kNone;
}

}  // namespace

NamesakeWatch::Action NamesakeWatch::OnStatus(const ProcessIdentity& other, const ProcessIdentity& own,
                                              double now_s) {
  if (other.source == own_source_) return Action::kNone;
  if (seen_.size() >= kMaxNamesakes && !seen_.contains(other.source)) seen_.clear();
  Seen& seen = seen_.try_emplace(other.source, Seen{now_s, other.uptime_s, false}).first->second;
  const bool is_older = IsOlder(other, own);
  const double known_s = now_s - seen.first_s;
  if (!RunsFor(known_s, other.uptime_s - seen.first_uptime_s)) return is_older ? Action::kNone : Reply(other);
  const bool starts = own.uptime_s < kStartWindow_s + kStartProof_s;
  if (is_older && known_s >= (starts ? kStartProof_s : kProof_s)) return Action::kYield;
  if (!is_older && known_s >= kPatience_s && !seen.is_reported) {
    seen.is_reported = true;
    return Action::kReport;
  }
  return is_older ? Action::kNone : Reply(other);
}

std::string NamesakeWatch::Sentence(const std::string& process, const ProcessIdentity& other) {
  return fmt::format("another {} is running on this bus: process {} on {}, for {:.0f} s", process, other.pid,
                     other.host, other.uptime_s);
}

}  // namespace plslam::bus
