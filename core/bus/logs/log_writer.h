// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "core/bus/bus.h"
#include "core/bus/transport/wire.h"

namespace plslam::bus {

/// Writes LCM event logs that lcm-logplayer reads. Throws std::runtime_error with one sentence if the file cannot be
/// written; the written part is kept, but no empty file.
class LogWriter {
 public:
  explicit LogWriter(const std::string& path);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  void Write(std::string_view channel, ByteView data, int64_t timestamp_us);
  void Flush();
  int64_t events() const { return events_; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  [[noreturn]] void Fail();

  std::string path_;
  int64_t events_ = 0;
  bool failed_ = false;
};

/// Records everything on the bus into an LCM log (`plslam record`). Unlike lcm-logger it is a full reader of the
/// ordered channels: missing messages are resent, and publishers wait for it, so that the log has no gaps. MACs are
/// checked, and not recorded. Messages of channels that are not in the table are recorded unchecked.
///
/// After a failed write (a full disk) it records nothing more, and discards messages instead: publishers need not wait.
class LogRecorder {
 public:
  /// Throws std::runtime_error if the file cannot be created.
  LogRecorder(const BusOptions& options, const std::string& path);

  /// `on_failure` gets the sentence of the first failed write, on the thread of the bus. Set it before `Run`.
  void OnFailure(std::function<void(const std::string& sentence)> on_failure) { on_failure_ = std::move(on_failure); }
  /// Records until `Stop` (from any thread), and then the messages that it has acknowledged.
  void Run();
  void Stop();

  int64_t events() const { return events_; }
  /// Returns whether it has recorded a message about more than the bus and its processes: a frame, a pose, an order.
  bool has_content() const { return has_content_; }
  /// Sentence of the failed write; empty if all were written.
  const std::string& failure() const { return failure_; }
  BusCounters counters() const { return bus_.counters(); }
  Bus& bus() { return bus_; }

 private:
  void Record(std::string_view channel, ByteView data);
  /// Calls it unless a write has failed.
  void Try(const std::function<void()>& write);

  LogWriter writer_;
  std::string failure_;
  std::function<void(const std::string& sentence)> on_failure_;
  std::atomic<int64_t> waiting_bytes_ = 0;
  std::atomic<int64_t> events_ = 0;
  std::atomic<bool> has_content_ = false;
  Bus bus_;  // last: its thread uses the others
};

}  // namespace plslam::bus
