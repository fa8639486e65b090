// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "core/bus/channels.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// Where the histories of processes lie that name no folder for them: TMPDIR, or /tmp; and the one of a process.
std::string TemporaryRoot();
std::string TemporaryFolder(int64_t source);

/// The sent messages of one ordered channel, by number, for those that ask again. Memory is bounded: beyond
/// `memory_bytes` a kAll history moves its oldest messages to an LCM log, a kUnacknowledged one forgets them.
class History {
 public:
  /// `path` is the log of kAll, made when it is first needed. Unless `keep_file` it loses its name at once, and its
  /// folder too, so that nothing is left even of a process that is killed.
  History(Retention retention, int64_t memory_bytes, std::string channel, std::string path, bool keep_file);
  ~History();
  History(const History&) = delete;
  History& operator=(const History&) = delete;

  /// The next message: its number is `next_seq()`.
  void Append(Bytes message);
  /// nullptr where it is not kept any more, or was never sent.
  Bytes Get(int64_t seq);
  /// kUnacknowledged: everything below `seq` is no longer needed. kAll ignores it.
  void Forget(int64_t seq);

  Retention retention() const { return retention_; }
  int64_t first_seq() const { return first_seq_; }
  int64_t next_seq() const { return memory_first_ + static_cast<int64_t>(memory_.size()); }
  int64_t memory_bytes() const { return bytes_; }
  /// Messages in the log.
  int64_t spilled() const { return static_cast<int64_t>(offsets_.size()); }

 private:
  struct Log;
  void DropOldest();
  bool Spill(const Bytes& message);
  void RemoveFile() const;
  Bytes ReadSpilled(int64_t seq);

  Retention retention_;
  int64_t memory_limit_;
  std::string channel_;
  std::string path_;
  bool keep_file_;
  std::deque<Bytes> memory_;
  int64_t memory_first_ = 0;
  int64_t first_seq_ = 0;
  int64_t bytes_ = 0;
  std::vector<int64_t> offsets_;  // places in the log of the messages 0, 1, ...
  std::unique_ptr<Log> log_;
  bool log_failed_ = false;
};

}  // namespace plslam::bus
