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
#include "tools/plslam/child_process.h"
#include "tools/plslam/run_bus.h"

namespace plslam::test {

/// A message of a log.
struct LoggedMessage {
  const bus::Channel* channel = nullptr;
  std::string publisher;  ///< "vo"
  std::string key;        ///< which of its channel, in words ("of frame 17"); empty where that is not asked
  std::vector<uint8_t> bytes;
};

/// What player, vo, mapping and loop said in a recorded run, in the order of the log.
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

/// vo, mapping, loop and viewer.
const std::vector<ReplayedProcess>& ReplayedProcesses();

/// What happens to a process while a log is played to it.
struct ReplayFaults {
  double drop_fraction = 0.0;  ///< of the datagrams it receives
  bool doubled = false;        ///< each datagram that is sent to it comes twice
  /// It is killed and started again behind this message of the log.
  std::optional<size_t> killed_behind = std::nullopt;
  /// Few updates of the map are kept for it: it has to ask for the whole map when it is started again.
  bool few_updates = false;
};

/// Plays a log to a single process, in the place of all the others, and compares what it says with what it said in the
/// log.
///
/// The messages are gone through in the order of the log: an input is published, and an output is waited for. In
/// lockstep what a process says depends on the inputs alone, each of which takes effect at a fixed place, and so it is
/// the same, bit for bit; but for times that were measured, and the random names of the processes.
class ProcessReplay {
 public:
  /// `folder` gets the files and the log of the process.
  ProcessReplay(const MessageLog& log, const ReplayedProcess& process, ReplayFaults faults,
                std::filesystem::path folder);
  ~ProcessReplay();
  ProcessReplay(const ProcessReplay&) = delete;
  ProcessReplay& operator=(const ProcessReplay&) = delete;

  /// The first difference, in one sentence; empty where there is none. After a restart what holds in the end is
  /// compared: of a message that was said again any one, and of mapping_process, which numbers the versions of its map
  /// anew, the map.
  std::string Play();

  /// A counter of the last status of the process.
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
  /// Where the tracker goes back, `next` does.
  void Restart(size_t* next);
  void GoBack(int64_t frame_id, size_t* next);
  void AwaitEnd();
  void Stop();

  /// Waits until `done`, and looks at what the process says meanwhile. Where it does not come to that, the difference
  /// is that `what` has not come.
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
  /// The tracker has gone back: up to this message of the log frames alone are said again.
  size_t again_until_ = 0;

  std::vector<LoggedMessage> messages_;  ///< of the log, in the names of those who play them
  std::map<std::pair<std::string, std::string>, const LoggedMessage*> expected_;  ///< by channel and key
  std::map<std::string, std::vector<std::string>> order_;                         ///< keys by channel
  std::map<std::string, size_t> n_said_;
  std::set<std::pair<std::string, std::string>> said_keys_;
  MapFollower map_;

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
