// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/bus/channels.h"
#include "core/bus/transport/wire.h"
#include "core/ids/ids.h"

namespace plslam::bus {

/// Returns the folder for the history of a process that configures none.
std::string TemporaryFolder(SourceId source);

/// The sent messages of one ordered channel, by number, for repair requests. Memory is bounded: beyond `memory_bytes` a
/// kUnacknowledged history drops its oldest messages, and a kAll one requests, beyond an eighth of that, that they be
/// moved to a `HistoryLog`, from which it drops them beyond `disk_bytes`. It does not access the disk itself, so that
/// its owner holds the mutex that guards it for bookkeeping only:
///
///   Append  ->  while (message = ToMove()) { offset = log.Write(message); log.Release(Moved(offset)); }
///   Find    ->  the message, or the offset for log.Read
class History {
 public:
  /// A message that is kept: in memory, or else at `offset` of the log.
  struct Kept {
    Bytes message;
    int64_t offset = -1;
    size_t bytes = 0;
  };

  /// A day of poses at 20 Hz, or 10,000 keyframes.
  static constexpr int64_t kDiskBytes = 1'500'000'000;

  History(Retention retention, int64_t memory_bytes, int64_t disk_bytes = kDiskBytes)
      : retention_(retention), memory_limit_(memory_bytes), disk_limit_(disk_bytes) {}

  /// The next message: its number is `next_seq()`.
  void Append(Bytes message);
  /// Returns the oldest message in memory if it is to be moved to the log; nullptr if memory is within its bound.
  Bytes ToMove() const;
  /// Records that this message is stored at `offset` of the log, or could not be written (nullopt). Without a log the
  /// history begins later from then on, as announcements then state. Returns where the part of the log begins that is
  /// still needed.
  int64_t Moved(std::optional<int64_t> offset);

  /// Returns nullopt if the message was dropped or never sent.
  std::optional<Kept> Find(int64_t seq) const;
  /// kUnacknowledged: everything below `seq` is no longer needed. kAll ignores it.
  void Forget(int64_t seq);

  Retention retention() const { return retention_; }
  int64_t first_seq() const { return first_seq_; }
  int64_t next_seq() const { return memory_first_ + static_cast<int64_t>(memory_.size()); }
  int64_t memory_bytes() const { return bytes_; }
  /// Messages in the log.
  int64_t moved() const { return static_cast<int64_t>(moved_.size()); }

 private:
  struct Place {
    int64_t offset = 0;
    size_t bytes = 0;
  };
  bool UsesLog() const { return retention_ == Retention::kAll && !log_failed_; }
  void DropOldest();

  Retention retention_;
  int64_t memory_limit_;
  int64_t disk_limit_;
  std::deque<Bytes> memory_;
  int64_t memory_first_ = 0;
  int64_t first_seq_ = 0;
  int64_t bytes_ = 0;
  std::deque<Place> moved_;  // the messages from `first_seq_` on in the log
  int64_t moved_bytes_ = 0;
  bool log_failed_ = false;
};

/// The LCM log that a history moves its oldest messages to. One thread may write while another reads earlier messages.
class HistoryLog {
 public:
  /// The file is created when it is first needed. Unless `keep_file`, its name is removed at once, and its folder too,
  /// so that no file is left even by a process that is killed.
  HistoryLog(std::string channel, std::string path, bool keep_file);
  ~HistoryLog();
  HistoryLog(const HistoryLog&) = delete;
  HistoryLog& operator=(const HistoryLog&) = delete;

  /// Returns the offset of the message in the file; nullopt if the disk rejects it (full, removed).
  std::optional<int64_t> Write(const Bytes& message);
  /// Returns nullptr if it cannot be read.
  Bytes Read(int64_t offset);
  /// Returns the disk's space before `offset` to the system, if its file system can do that. Messages there can no
  /// longer be read.
  void Release(int64_t offset);

 private:
  struct Files;
  void RemoveFile() const;

  std::string channel_;
  std::string path_;
  bool keep_file_;
  std::unique_ptr<Files> files_;
  int64_t released_ = 0;
};

}  // namespace plslam::bus
