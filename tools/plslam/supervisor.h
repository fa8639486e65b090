// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tools/plslam/child_process.h"

namespace plslam::launcher {

/// What a supervised process did, over all its starts.
struct ProcessReport {
  std::string name;
  double cpu_s = 0.0;
  double peak_memory_mb = 0.0;
  int restarts = 0;
  /// Of the last start; nothing while it runs.
  std::optional<int> exit_code;
  /// Longest time from the end of a process until the one in its place was ready.
  double slowest_restart_s = 0.0;
  /// What waited in its queues at most, as its status told; the supervisor does not know.
  double longest_queue = 0.0;
  /// That ended it; 0: none.
  int exit_signal = 0;
};

/// Starts processes, starts those that crash again (a bounded number of times, with pauses that grow as long as none
/// gets ready), and stops all of them: `bus::kStopOrder`, and SIGKILL where that is of no avail. What goes wrong
/// while they stop is a failure, too. Knows nothing of messages; time is told by the caller.
class Supervisor {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  struct Options {
    std::filesystem::path bin;   ///< folder of the executables
    std::filesystem::path logs;  ///< folder for NAME.log
    int max_restarts = 5;        ///< of each process
    std::chrono::milliseconds first_pause{200};
    std::chrono::milliseconds patience{5000};  ///< after the order to stop
    /// Arguments of a process that is started again for the `restart`-th time, from those of its first start. May be
    /// empty: they stay.
    std::function<std::vector<std::string>(const std::string& name, int restart, std::vector<std::string> arguments)>
        arguments_of_restart;
    /// A process with this id has ended. May be empty.
    std::function<void(pid_t pid)> on_exit;
    /// What a process with this id said of its own failure: its log may be on a full disk. May be empty.
    std::function<std::string(pid_t pid)> last_word{};
    std::chrono::milliseconds patience_with_writers{60000};  ///< in place of `patience`
    /// A process has ended ("was ended by SIGKILL") and will be started again for the `restart`-th time. May be
    /// empty.
    std::function<void(const std::string& name, const std::string& how, int restart)> on_restart = nullptr;
  };

  /// What a process may do by itself.
  enum class Ending {
    kRestart,  ///< it must run until stopped; where it ends it is started again
    kMayEnd,   ///< it may end with exit code 0; ended by a signal it is started again, any other code fails the run
    /// It must run until stopped, and then still writes what the run is for, which may take long. Ended by a signal
    /// it is started again; ended by an error of its own (a full disk) it fails the run, since it would end by it
    /// again.
    kWritesAtTheEnd,
  };

  explicit Supervisor(Options options);

  /// `niceness` as in `ChildProcess`. Throws std::runtime_error where the program cannot be started.
  void Start(const std::string& name, const std::string& executable, const std::vector<std::string>& arguments,
             Ending ending, int niceness = 0);
  /// From here on an exit code of this process leads to a restart; before (while it reads its options) to a failure.
  /// One that is ended by a signal is started again at any time.
  void SetReady(const std::string& name, TimePoint now);
  /// -1 where it does not run.
  pid_t pid(const std::string& name) const;

  /// Looks after all of them; call it often.
  void Tick(TimePoint now);
  /// Why the run cannot go on, or what went wrong while it was stopped; empty where all is well.
  std::string failure() const;
  /// The process that this is about.
  const std::string& failed() const { return failed_; }

  /// Orders one process to end, and does not start it again.
  void Interrupt(const std::string& name);
  void Stop(TimePoint now);
  /// Kills all that run, and starts nothing any more; from any thread.
  void KillAll();
  /// True when nothing runs any more.
  bool stopped() const;

  std::vector<ProcessReport> reports() const;
  int restarts() const;

 private:
  struct Child {
    std::string name;
    std::string executable;
    std::vector<std::string> arguments;
    Ending ending;
    int niceness = 0;
    bool ready = false;        ///< was, once
    bool ready_again = false;  ///< since the last start
    bool interrupted = false;  ///< it alone: however it ends is well
    int signal = 0;            ///< the last one we sent to stop it; 0: none
    int failed_starts = 0;     ///< in a row, that did not get ready
    std::unique_ptr<ChildProcess> process;
    std::optional<TimePoint> start_at;
    TimePoint ended_at;
    ProcessReport report;
  };

  void Spawn(Child* child);
  bool MayRestart(const Child& child, const ChildExit& end) const;
  void HandleExit(Child* child, const ChildExit& end, TimePoint now);
  bool IsWell(const Child& child, const ChildExit& end) const;
  void Fail(const Child& child, pid_t pid);
  static void Order(Child* child);
  void HurryUp(Child* child, TimePoint now) const;
  std::filesystem::path LogOf(const std::string& name) const { return options_.logs / (name + ".log"); }

  Options options_;
  std::mutex mutex_;  ///< held where a process is started or reaped, so that `KillAll` meets none that is reaped
  bool killed_ = false;
  std::vector<Child> children_;
  std::string failure_;  ///< without the reason
  std::string failed_;
  pid_t failed_pid_ = -1;
  std::optional<TimePoint> stopping_since_;
};

/// "was ended by SIGKILL" or "ended with exit code 1".
std::string HowItEnded(const ChildExit& end);

/// The last line of a text file that is not empty; empty where there is none.
std::string LastLine(const std::filesystem::path& file);

}  // namespace plslam::launcher
