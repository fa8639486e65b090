// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

namespace plslam::bus {

/// Reason why a message is rejected.
enum class Rejection {
  kMalformed,     ///< invalid sizes, strings or header
  kOversized,     ///< larger than any message of plslam
  kOtherVersion,  ///< LCM's fingerprint is not that of our version of the type
  kOtherSchema,   ///< `header_t.schema` is not ours
  kNoKey,         ///< we have a key; it has no MAC
  kOtherKey,      ///< we have a key; its MAC is not of that key, or the message has been altered
  kReplayed,      ///< genuine, but its sender does not answer: it has exited
  kNumber         // of the above
};

/// Rejected messages by reason, and foreign traffic: counted, logged once, and shown as one line in the status. Time in
/// nanoseconds of any steady clock. Safe from any thread.
class Rejections {
 public:
  /// Returns true for the first of its kind, which is worth a line in the log.
  bool Count(Rejection why, std::string_view channel, int64_t now);
  /// Notes a process with another prefix; true for the first message with that prefix.
  bool OtherPrefix(std::string_view prefix, int64_t now);

  /// Whether there was one within the last minute.
  bool Has(Rejection why, int64_t now) const;
  /// Returns "messages rejected: 1204 altered or with another bus.key_file (POSE), 3 malformed (STATUS)" about the last
  /// minute; empty if none were.
  std::string Line(int64_t now) const;

  /// Description of a rejected message: "it is ...".
  static std::string_view Text(Rejection why);
  static std::string PrefixText(std::string_view prefix);

 private:
  struct Row {
    int64_t count = 0;
    int64_t last = 0;
    std::string channel;
  };
  static bool IsRecent(const Row& row, int64_t now);

  mutable std::mutex mutex_;  // guards all of the following
  std::array<Row, static_cast<size_t>(Rejection::kNumber)> rows_;
  std::map<std::string, int64_t, std::less<>> prefixes_;  // when heard last
};

}  // namespace plslam::bus
