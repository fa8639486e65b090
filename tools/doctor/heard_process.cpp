// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/heard_process.h"
#include "core/run/process_names.h"

#include <cmath>
#include <set>
#include <tuple>

#include <fmt/format.h>

namespace plslam::doctor {
namespace {

constexpr double kSkew_s = 0.05;

std::string NameOf(const HeardProcess& p) {
  return fmt::format("{}{} on {} (process {})", p.prefix, p.process, p.host, p.pid);
}

std::string Kill(const HeardProcess& p, const OwnSide& own) {
  const std::string kill = fmt::format("kill {}", p.pid);
  return p.host == own.host ? kill : fmt::format("ssh {} {}", p.host, kill);
}

double Count(const HeardProcess& p, const std::string& counter) {
  const auto it = p.counters.find(counter);
  return it == p.counters.end() ? 0.0 : it->second;
}

void CheckKey(const HeardProcess& p, const OwnSide& own, Findings* findings) {
  static constexpr char kMend[] =
      "--set bus.key_file=FILE   # for every process, with the same FILE: (umask 077; openssl rand -hex 32 >FILE)";
  if (p.signature == Signature::kUnchecked && !own.has_key) {
    findings->push_back(Problem(
        "key", NameOf(p) + " signs its messages, and no key is set here: it will reject messages of this host",
        kMend));
  } else if (p.signature == Signature::kNone && own.has_key) {
    findings->push_back(Problem(
        "key", NameOf(p) + " does not sign its messages, and a key is set here: its messages are rejected", kMend));
  } else if (p.signature == Signature::kWrong) {
    findings->push_back(Problem("key", NameOf(p) + " has a key that differs from the one set here", kMend));
  }
}

void CheckVersion(const HeardProcess& p, const OwnSide& own, Findings* findings) {
  static constexpr char kMend[] = "plslam --version   # on every host: install the same version";
  if (p.schema != own.schema) {
    findings->push_back(Problem(
        "version",
        fmt::format("{} uses version {} of the messages, this build version {}", NameOf(p), p.schema, own.schema),
        kMend));
  } else if (!p.version.empty() && p.version != own.version) {
    findings->push_back(
        Advice("version", fmt::format("{} is version {}, this one {}", NameOf(p), p.version, own.version), kMend));
  }
}

void CheckHealth(const HeardProcess& p, const OwnSide& own, Findings* findings) {
  if (p.state == process_state::kFailed) {
    findings->push_back(Problem("process", fmt::format("{} has failed: {}", NameOf(p), p.reason),
                                "systemctl status 'plslam-*'   # or its log in OUT/logs"));
  } else if (!p.reason.empty() && Count(p, "bus.rejected") > 0) {
    findings->push_back(
        Advice("process", fmt::format("{} reports: {}", NameOf(p), p.reason), "plslam doctor   # on " + p.host));
  }
  const double lost = Count(p, "bus.lost"), received = Count(p, "bus.received");
  if (lost > 20 && lost > 0.01 * received) {
    findings->push_back(Advice("network",
                               fmt::format("{} needed {:.1f} % of its messages to be sent again", NameOf(p),
                                           100.0 * lost / (received + lost)),
                               "--set bus.max_message_bytes=1200   # for every process"));
  }
  if (p.clock_ahead_s && std::abs(*p.clock_ahead_s) > kSkew_s && p.host != own.host) {
    findings->push_back(Advice(
        "clock", fmt::format("the clock of {} differs by {:+.2f} s from that of this host", p.host, *p.clock_ahead_s),
        fmt::format("ssh {} sudo timedatectl set-ntp true", p.host)));
  }
}

/// Two of these under one prefix do each other's work.
void CheckDoubles(const Heard& heard, const OwnSide& own, Findings* findings) {
  std::map<std::tuple<std::string, std::string>, const HeardProcess*> first;
  for (const HeardProcess& p : heard.processes) {
    if (p.process != process_name::kMapping && p.process != process_name::kLoop) continue;
    const auto [it, fresh] = first.insert({{p.prefix, p.process}, &p});
    if (fresh || it->second->source == p.source) continue;
    findings->push_back(Problem("process",
                                fmt::format("{} and {} run at the same time: one map has only one {}",
                                            NameOf(*it->second), NameOf(p), p.process),
                                Kill(p, own)));
  }
}

void CheckPrefixes(const Heard& heard, const OwnSide& own, Findings* findings) {
  std::set<std::string> others;
  bool ours = false;
  for (const HeardProcess& p : heard.processes) {
    ours = ours || p.prefix == own.prefix;
    if (p.prefix != own.prefix) others.insert(p.prefix);
  }
  for (const std::string& prefix : others) {
    const std::string what = prefix.empty() ? "processes without a prefix were found"
                                            : fmt::format("processes with the prefix '{}' were found", prefix);
    const std::string mend =
        prefix.empty() ? "plslam doctor   # without --prefix" : "plslam doctor --prefix " + prefix;
    findings->push_back(
        ours ? Good("prefix", what + ": another robot's")
             : Problem("prefix", what + fmt::format(", but none with the prefix of this host ('{}')", own.prefix),
                       mend));
  }
}

}  // namespace

Findings CheckProcesses(const Heard& heard, const OwnSide& own) {
  Findings findings;
  CheckPrefixes(heard, own, &findings);
  CheckDoubles(heard, own, &findings);
  for (const HeardProcess& p : heard.processes) {
    CheckVersion(p, own, &findings);
    if (p.prefix == own.prefix) CheckKey(p, own, &findings);
    CheckHealth(p, own, &findings);
  }
  for (const auto& [channel, count] : heard.foreign_types) {
    findings.push_back(Problem(
        "version", fmt::format("{} messages on {} are not of the type that this build expects there", count, channel),
        "plslam --version   # on every host: install the same version"));
  }
  if (heard.other_channels > 0) {
    findings.push_back(Good(
        "process", fmt::format("{} messages of other programs were received on {}", heard.other_channels, own.url)));
  }
  for (const HeardProcess& p : heard.processes) {
    findings.push_back(Good("process", fmt::format("{}: {}, version {}", NameOf(p), p.state, p.version)));
  }
  if (heard.processes.empty()) findings.push_back(Good("process", "no process was found on " + own.url));
  return findings;
}

}  // namespace plslam::doctor
