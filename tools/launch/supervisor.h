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

#include "tools/launch/child_process.h"

namespace plslam::launcher {

/// Report of a supervised process, over all its starts.
struct ProcessReport {
  std::string name;
  double cpu_s = 0.0;
  double peak_memory_mb = 0.0;
  int restarts = 0;
  /// Exit code of the last start; nullopt while it runs.
  std::optional<int> exit_code;
  /// Longest time from the exit of a process until its replacement was ready.
  double slowest_restart_s = 0.0;
  /// Longest queue according to its status; not set by the supervisor.
  double longest_queue = 0.0;
  /// Signal that ended it; 0: none.
  int exit_signal = 0;
};

/// Starts processes, restarts those that crash (a bounded number of times, with pauses that grow until one gets ready),
/// and stops all of them: `bus::kStopOrder`, then SIGKILL if that has no effect. An error during the stop is a failure,
/// too. Independent of messages; the caller passes the time.
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
    /// Called when the process with this id has exited. May be empty.
    std::function<void(pid_t pid)> on_exit;
    /// Returns the failure that the process with this id has published: its log may be on a full disk. May be empty.
    std::function<std::string(pid_t pid)> last_word{};
    std::chrono::milliseconds patience_with_writers{60000};  ///< replaces `patience` for these
    /// Called when a process has ended ("was ended by SIGKILL") and will be restarted for the `restart`-th time. May be
    /// empty.
    std::function<void(const std::string& name, const std::string& how, int restart)> on_restart = nullptr;
  };

  /// Allowed ways for a process to exit by itself.
  enum class Ending {
    kRestart,  ///< must run until stopped; restarted if it exits
    kMayEnd,   ///< may exit with code 0; restarted if a signal ended it; any other code fails the run
    /// Must run until stopped, and then still writes the results of the run, which may take long. If a signal ended it,
    /// it is restarted; an error of its own (a full disk) fails the run, since it would recur.
    kWritesAtTheEnd,
  };

  explicit Supervisor(Options options);

  /// `niceness` as in `ChildProcess`. Throws std::runtime_error where the program cannot be started.
  void Start(const std::string& name, const std::string& executable, const std::vector<std::string>& arguments,
             Ending ending, int niceness = 0);
  /// From here on an exit code of this process causes a restart; before (while it reads its options) a failure. A
  /// process that is ended by a signal is restarted at any time.
  void SetReady(const std::string& name, TimePoint now);
  /// Returns -1 if it does not run.
  pid_t pid(const std::string& name) const;

  /// Monitors all processes; call it often.
  void Tick(TimePoint now);
  /// Reason why the run cannot continue, or error during the stop; empty if there is none.
  std::string failure() const;
  /// Name of the process that failed.
  const std::string& failed() const { return failed_; }

  /// Commands one process to stop, and does not restart it.
  void Interrupt(const std::string& name);
  void Stop(TimePoint now);
  /// Kills all running processes, and starts no others; safe from any thread.
  void KillAll();
  /// Returns true when no process runs.
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
    bool interrupted = false;  ///< only this one: any exit is regular
    int signal = 0;            ///< the last one sent to stop it; 0: none
    int failed_starts = 0;     ///< in a row, that did not get ready
    std::unique_ptr<ChildProcess> process;
    std::optional<TimePoint> start_at;
    TimePoint ended_at;
    ProcessReport report;
  };

  void Spawn(Child* child);
  bool MayRestart(const Child& child, const ChildExit& end) const;
  void HandleExit(Child* child, const ChildExit& end, TimePoint now);
  bool ExitedNormally(const Child& child, const ChildExit& end) const;
  void Fail(const Child& child, pid_t pid);
  static void Order(Child* child);
  void ShortenDeadline(Child* child, TimePoint now) const;
  std::filesystem::path LogOf(const std::string& name) const { return options_.logs / (name + ".log"); }

  Options options_;
  std::mutex mutex_;  ///< locked while a process is started or reaped, so that `KillAll` signals none that is reaped
  bool killed_ = false;
  std::vector<Child> children_;
  std::string failure_;  ///< without the reason
  std::string failed_;
  pid_t failed_pid_ = -1;
  std::optional<TimePoint> stopping_since_;
};

/// "was ended by SIGKILL" or "ended with exit code 1".
std::string ExitText(const ChildExit& end);

/// Returns the last line of a text file that is not empty; an empty string if there is none.
std::string LastLine(const std::filesystem::path& file);

}  // namespace plslam::launcher
