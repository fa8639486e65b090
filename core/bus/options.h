// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/config/fields.h"

namespace plslam::bus {

/// How a process joins the bus. Users set those of `VisitFields`; tests change the others.
struct BusOptions {
  /// Any LCM URL: udpm, tcpq, file, memq. Empty: LCM_DEFAULT_URL, or LCM's default.
  std::string url;
  /// Put in front of each channel name: one for each robot.
  std::string prefix;
  /// Prefix of the map that the robot shares with others: that of their mapping_process. Empty: its own.
  std::string map_prefix;
  /// Largest payload of a message; pages and strips are cut to it. About 1200 across links that lose packets.
  int64_t max_message_bytes = 60000;
  /// File with a shared key (64 hex digits); with one, messages without a valid MAC are rejected.
  std::string key_file;
  /// Folder for the history of ordered channels beyond memory. Empty: a folder of the process under TMPDIR.
  std::string history_dir;
  /// Longest time that publishing waits for a slow reader; then the reader is left to repair until it has caught up.
  int64_t max_wait_ms = 1000;
  /// Time after which gaps in the messages of a silent publisher are given up (a link may be cut). Publishers keep
  /// messages twice as long for readers that have fallen silent.
  double give_up_s = 30.0;
  /// Time after which a lockstep stream continues without a process, or an input, of which nothing is heard.
  double partner_wait_s = 15.0;
  /// Memory of an ordered channel's history for repair; messages beyond it go to disk (kAll) or are dropped
  /// (kUnacknowledged).
  int64_t history_bytes = 32'000'000;
  /// Bytes that may wait for the handlers of this process; when they are reached, publishers are held back.
  int64_t queue_bytes = 64'000'000;
  /// Share of received datagrams dropped on purpose, for tests.
  double drop_fraction = 0.0;
  int64_t drop_seed = 1;
};

template <class Visitor>
void VisitFields(Visitor& visit, BusOptions& o) {
  visit("url", o.url, "LCM URL (udpm, tcpq, file, memq); empty: LCM_DEFAULT_URL");
  visit("prefix", o.prefix, "prefix of each channel name, one for each robot");
  visit("map_prefix", o.map_prefix, "prefix of the map that the robot shares with others; empty: not shared");
  visit("max_message_bytes", o.max_message_bytes, Bounds{1000, 60000}, "largest message; 1200 on lossy links");
  visit("key_file", o.key_file, "file with a shared key of 64 hex digits; empty: no authentication");
  visit("history_dir", o.history_dir, "folder for the history of ordered channels; empty: under TMPDIR");
  visit("give_up_s", o.give_up_s, Bounds{0.1, 3600},
        "how long a silent publisher is considered disconnected, not dead");
  visit("partner_wait_s", o.partner_wait_s, Bounds{0, 3600},
        "how long a lockstep stream waits for a process, or an input, of which nothing is heard");
  visit("history_bytes", o.history_bytes, Bounds{200000, 4e9}, "memory for repair, of each ordered channel");
  visit("drop_fraction", o.drop_fraction, Bounds{0, 0.9},
        "share of received datagrams dropped on purpose, for tests");
}

}  // namespace plslam::bus
