// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/bus/bus.h"
#include "core/config/config.h"

namespace CLI {
class App;
}

namespace plslam::bus {

/// The services of a process that its node uses: the bus, and the status that it publishes.
class Process {
 public:
  /// Starts in state "starting". Throws the exceptions of Bus.
  Process(const std::string& name, const BusOptions& options);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  Bus& bus() { return *bus_; }
  const std::string& name() const { return name_; }
  /// Whether a launcher started it (`--parent`), rather than a user or a service.
  bool has_launcher() const;

  /// Sets the state ("ready", "running", "finished"...), which is published at once and at 1 Hz with counters, CPU time
  /// and memory, and printed on the terminal of a process that was started by hand. RunProcess sets "ready" after
  /// `make_node` if the node has set no state itself.
  void SetState(const std::string& state, const std::string& reason = "");
  /// Sets the reason beside the state, which does not change; published at once.
  void SetReason(const std::string& reason);
  /// Reports once what can make results wrong or incomplete: in the log, in the status and, as `warning_t`, to summaries
  /// and reports of runs. `code` is for programs ("masks_missing"), `sentence` for users: finding, meaning and remedy.
  /// Returns false if it has been reported before.
  bool Warn(const std::string& code, const std::string& sentence);
  /// Sets the effective configuration of the node's own sections; that of the bus is prepended. A configuration that
  /// does not fit into a message is truncated at a line end, and its last line says so.
  void SetConfiguration(const std::string& yaml);
  /// A named number of the status ("queue.frames", "frames.skipped").
  void SetCounter(const std::string& name, double value);

  /// Ends the run; the process then exits with `exit_code`. Safe from handlers and threads.
  void Finish(int exit_code = 0);

 private:
  friend class ProcessRunner;
  /// Stops, because another process of this name has run for longer (`NamesakeWatch`).
  void Yield(const std::string& sentence);
  struct Impl;
  std::string name_;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Impl> impl_;
};

/// A process of the system.
struct ProcessSpec {
  std::string name;         ///< "vo"
  std::string description;  ///< for --help
  std::string examples;     ///< for --help: one a line, each beginning with two blanks
  /// Adds the process's own options to the command line; may be empty. Include <CLI/CLI.hpp> to use it.
  std::function<void(CLI::App* app)> add_options;
  /// Makes the node: reads its options from the configuration, subscribes, and returns the object to keep until the
  /// end.
  std::function<std::shared_ptr<void>(Process&, const Config&)> make_node;
  /// For the terminal: the inputs it waits for ("a camera and frames"); may be empty.
  std::string waits_for;
  /// For the terminal: counters of its results in the status, each with its noun ("frames.sent", "frames sent").
  std::vector<std::pair<std::string, std::string>> results;
};

/// Returns `make_node` for a node whose options are a section of the configuration.
template <class Node, class Options>
std::function<std::shared_ptr<void>(Process&, const Config&)> NodeWithOptions(const std::string& section) {
  return [section](Process& process, const Config& config) {
    Options options;
    config.Read(section, options);
    return std::make_shared<Node>(process, options);
  };
}

/// The one main of all processes: command line (`--config FILE`, `--set KEY=VALUE`, `--url`, `--prefix`, `--help`,
/// `--version`), configuration, bus, node, run loop. SIGINT, SIGTERM and SIGHUP end it cleanly (exit code 0), a
/// second one at once (SignalWatcher); an exception becomes one line on stderr, state "failed", and exit code 1.
int RunProcess(int argc, char** argv, const ProcessSpec& spec);

}  // namespace plslam::bus
