#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/plslam/child_process.h"

namespace plslam {

/// What a supervised process did, over all its starts.
struct ProcessReport {
  std::string name;
  double cpu_s = 0.0;
  double peak_memory_mb = 0.0;
  int restarts = 0;
  /// Of the last start; nothing while it runs.
  std::optional<int> exit_code;
};

/// Starts processes, starts those that crash again (with growing pauses, a bounded number of times), and stops all of
/// them: SIGINT, then SIGTERM, then SIGKILL. Knows nothing of the bus; time is told by the caller.
class Supervisor {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  struct Options {
    std::filesystem::path bin;   ///< folder of the executables
    std::filesystem::path logs;  ///< folder for NAME.log
    int max_restarts = 5;        ///< of each process
    std::chrono::milliseconds first_pause{200};
    std::chrono::milliseconds patience{5000};  ///< after each of SIGINT and SIGTERM
  };

  /// What a process may do by itself.
  enum class Ending {
    kRestart,  ///< it must run until stopped; where it ends it is started again
    kMayEnd,   ///< it may end with exit code 0; anything else fails the run
  };

  explicit Supervisor(Options options);

  /// Throws std::runtime_error where the program cannot be started.
  void Start(const std::string& name, const std::string& executable, const std::vector<std::string>& arguments,
             Ending ending);
  /// From here on a crash of this process leads to a restart; before (while it reads its options) to a failure.
  void SetReady(const std::string& name);
  /// -1 where it does not run.
  pid_t pid(const std::string& name) const;

  /// Looks after all of them; call it often.
  void Tick(TimePoint now);
  /// Why the run cannot go on; empty where it can.
  const std::string& failure() const { return failure_; }

  void Stop(TimePoint now);
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
    bool ready = false;
    std::unique_ptr<ChildProcess> process;
    std::optional<TimePoint> start_at;
    ProcessReport report;
  };

  void Spawn(Child* child);
  void HandleExit(Child* child, const ChildExit& end, TimePoint now);
  void SignalAll(int signal);
  std::filesystem::path LogOf(const std::string& name) const { return options_.logs / (name + ".log"); }

  Options options_;
  std::vector<Child> children_;
  std::string failure_;
  std::optional<TimePoint> stopping_since_;
  int signals_sent_ = 0;
};

/// The last line of a text file that is not empty; empty where there is none.
std::string LastLine(const std::filesystem::path& file);

}  // namespace plslam
