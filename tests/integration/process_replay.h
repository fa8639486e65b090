// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/bus/bus.h"
#include "plslam/status_t.hpp"
#include "tests/integration/played_process.h"
#include "tests/integration/recorded_run.h"
#include "tools/launch/child_process.h"
#include "tools/launch/run_bus.h"

namespace plslam::test {

/// A message of a log.
struct LoggedMessage {
  const bus::Channel* channel = nullptr;
  std::string publisher;  ///< "vo"
  std::string key;        ///< identity on its channel, in words ("of frame 17"); empty if that is not needed
  std::vector<uint8_t> bytes;
};

/// The messages of player, vo, mapping and loop in a recorded run, in the order of the log.
struct MessageLog {
  explicit MessageLog(const std::string& file);

  std::vector<LoggedMessage> messages;
  /// `header_t.source` by process.
  std::map<std::string, int64_t> sources;
};

/// A process that can be replayed: the channels that it reads, and those that it writes, by name.
struct ReplayedProcess {
  std::string name;
  std::string executable;
  std::set<std::string_view> inputs;
  std::set<std::string_view> outputs;
};

inline void PrintTo(const ReplayedProcess& process, std::ostream* out) { *out << process.name; }

/// The processes vo, mapping, loop and viewer.
const std::vector<ReplayedProcess>& ReplayedProcesses();

/// Faults of a process while a log is played to it.
struct ReplayFaults {
  double drop_fraction = 0.0;  ///< of the received datagrams
  bool doubled = false;        ///< each datagram is sent to it twice
  /// It is killed and restarted after this message of the log.
  std::optional<size_t> killed_behind = std::nullopt;
  /// Only few updates of the map are retained for it: it has to request the complete map after its restart.
  bool few_updates = false;
};

/// Plays a log to a single process, replacing all the others, and compares its messages with those in the log.
///
/// The messages are processed in the order of the log: an input is published, and an output is awaited. In lockstep the
/// outputs of a process depend on its inputs only, each of which takes effect at a fixed position, so that they are the
/// same, bit for bit, except for measured times and the random names of the processes.
class ProcessReplay {
 public:
  /// `folder` gets the files and the log of the process.
  ProcessReplay(const MessageLog& log, const ReplayedProcess& process, ReplayFaults faults,
                std::filesystem::path folder);
  ~ProcessReplay();
  ProcessReplay(const ProcessReplay&) = delete;
  ProcessReplay& operator=(const ProcessReplay&) = delete;

  /// Returns the first difference, in one sentence; empty if there is none. After a restart the final state is
  /// compared: any copy of a repeated message, and of mapping_process, whose map versions start again, the map.
  std::string Play();

  /// Returns a counter of the last status of the process.
  double Counter(const std::string& name) const;
  std::string Read(const std::string& file_of_out) const;
  std::string Log() const;

 private:
  struct Said {
    const bus::Channel* channel = nullptr;
    std::vector<uint8_t> bytes;
  };

  void Listen();
  void Start();
  void AwaitReady();
  void RenameLog();
  void Go();
  void Handle(const LoggedMessage& message, bool again);
  /// If the tracker goes back to earlier frames, so does `next`.
  void Restart(size_t* next);
  void GoBack(int64_t frame_id, size_t* next);
  void AwaitEnd();
  void Stop();

  /// Waits until `done`, and checks the outputs of the process meanwhile. At the time limit, the difference is that
  /// `what` has not arrived.
  void Await(const std::string& what, const std::function<bool()>& done);
  void LookAtSaid();
  void Compare(const Said& said);
  void CompareMaps();
  static bool IsFirstVersion(const bus::Channel& channel, bus::ByteView message);
  std::string KeyOf(const bus::Channel& channel, bus::ByteView message) const;
  /// The map of a mapping_process that is started again has other versions.
  bool comparesMaps() const { return faults_.killed_behind && process_.name == "mapping"; }
  status_t status() const;

  const MessageLog& log_;
  const ReplayedProcess process_;
  const ReplayFaults faults_;
  const std::filesystem::path folder_;
  launcher::PrivatePort port_;
  std::string difference_;
  bool restarted_ = false;
  /// The tracker has gone back: up to this message of the log only frames are repeated.
  size_t again_until_ = 0;

  std::vector<LoggedMessage> messages_;  ///< of the log, with the sources of the played processes
  std::map<std::pair<std::string, std::string>, const LoggedMessage*> expected_;  ///< by channel and key
  std::map<std::string, std::vector<std::string>> order_;                         ///< keys by channel
  std::map<std::string, size_t> n_said_;
  std::set<std::pair<std::string, std::string>> said_keys_;
  PublishedMap map_;

  std::map<std::string, std::unique_ptr<PlayedProcess>> played_;
  std::unique_ptr<Doubler> doubler_;
  std::unique_ptr<launcher::ChildProcess> child_;

  // Shared with the listener.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Said> said_;
  status_t status_{};
  std::optional<int64_t> go_back_to_;
  bus::Bus listener_;
  std::thread listening_;
};

}  // namespace plslam::test
