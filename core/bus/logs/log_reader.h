// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plslam::bus {

/// Reads LCM event logs (of lcm-logger, of `plslam record`) without trusting their content: sizes are checked against
/// the file, damaged stretches are skipped, and a truncated end is the end. Data are read on demand.
class LogReader {
 public:
  struct Event {
    int64_t timestamp_us = 0;
    std::string channel;
    int64_t data_offset = 0;
    int64_t data_bytes = 0;
    /// The first bytes of the data, at most kHeadBytes.
    std::vector<uint8_t> head;
  };
  static constexpr size_t kHeadBytes = 128;

  /// Throws std::runtime_error with one sentence where the file cannot be opened.
  explicit LogReader(const std::string& path);
  ~LogReader();
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  /// The next event, from the begin of the file on; nullopt at the end.
  std::optional<Event> Next();

  /// Returns the data at the offset of an event; nullopt if the file does not have them (any more). Safe from any
  /// thread.
  std::optional<std::vector<uint8_t>> Data(int64_t offset, int64_t bytes) const;

  /// Bytes that were skipped because they are no event.
  int64_t skipped_bytes() const { return skipped_bytes_; }

 private:
  bool ReadAt(int64_t offset, uint8_t* out, size_t bytes) const;
  bool FindSync();

  int fd_ = -1;
  int64_t size_ = 0;
  int64_t position_ = 0;
  int64_t skipped_bytes_ = 0;
};

/// Returns whether a file begins like an LCM event log.
bool LooksLikeLcmLog(const std::string& path);

}  // namespace plslam::bus
