#pragma once

#include <cstdint>
#include <string>

#include "core/config/fields.h"

namespace plslam::bus {

/// How a process joins the bus.
struct BusOptions {
  /// Any LCM URL: udpm, tcpq, file, memq. Empty: LCM_DEFAULT_URL, or LCM's default.
  std::string url;
  /// Put in front of each channel name: one for each robot.
  std::string prefix;
  /// Largest payload of a message; pages and strips are cut to it. About 1200 across links that lose packets.
  int64_t max_message_bytes = 60000;
  /// File with a shared key (64 hex digits); with one, messages without a valid MAC are rejected.
  std::string key_file;
  /// Folder for the history of ordered channels beyond memory. Empty: a folder of the process under TMPDIR.
  std::string history_dir;
  /// Fraction of received datagrams thrown away on purpose, for tests.
  double drop_fraction = 0.0;
  int64_t drop_seed = 1;
};

template <class Visitor>
void VisitFields(Visitor& visit, BusOptions& o) {
  visit("url", o.url, "LCM URL (udpm, tcpq, file, memq); empty: LCM_DEFAULT_URL");
  visit("prefix", o.prefix, "put in front of each channel name, one for each robot");
  visit("max_message_bytes", o.max_message_bytes, Bounds{1000, 60000}, "largest message; 1200 on links that lose");
  visit("key_file", o.key_file, "file with a shared key of 64 hex digits; empty: no authentication");
  visit("history_dir", o.history_dir, "folder for the history of ordered channels; empty: under TMPDIR");
  visit("drop_fraction", o.drop_fraction, Bounds{0, 0.9}, "received datagrams thrown away on purpose, for tests");
  visit("drop_seed", o.drop_seed, Bounds{0, 1e15}, "seed of that");
}

}  // namespace plslam::bus
