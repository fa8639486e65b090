#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/bus/bus.h"
#include "core/config/config.h"

namespace plslam::bus {

/// What a node gets to work with: the bus, and its face to the world (status).
class Process {
 public:
  Process(const std::string& name, const BusOptions& options);
  ~Process();

  Bus& bus() { return *bus_; }
  const std::string& name() const { return name_; }

  /// "ready", "running", "finished"...: published at once and at 1 Hz with counters, CPU time and memory.
  void SetState(const std::string& state, const std::string& reason = "");
  void SetConfiguration(const std::string& yaml);
  /// A named number of the status ("queue.frames", "frames.skipped").
  void SetCounter(const std::string& name, double value);

  /// Ends the run; the process then exits with `exit_code`. Safe from handlers and threads.
  void Finish(int exit_code = 0);

 private:
  friend int RunProcess(int, char**, const struct ProcessSpec&);
  std::string name_;
  std::unique_ptr<Bus> bus_;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A process of the system.
struct ProcessSpec {
  std::string name;         ///< "vo"
  std::string description;  ///< for --help
  /// Adds options of its own to the command line; may be empty. `app` is a CLI::App*.
  std::function<void(void* app)> add_options;
  /// Makes the node: reads its options from the configuration, subscribes, returns what must live until the end.
  std::function<std::shared_ptr<void>(Process&, const Config&)> make_node;
};

/// The one main of all processes: command line (`--config FILE`, `--set KEY=VALUE`, `--url`, `--prefix`, `--help`,
/// `--version`), configuration, bus, node, run loop. SIGINT and SIGTERM end it cleanly (exit code 0); an exception
/// becomes one line on stderr, state "failed", and exit code 1.
int RunProcess(int argc, char** argv, const ProcessSpec& spec);

}  // namespace plslam::bus
