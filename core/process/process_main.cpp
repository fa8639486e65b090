// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>

#include "core/bus/transport/transport.h"
#include "core/config/command_line_error.h"
#include "core/config/config.h"
#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/errors/standard_streams.h"
#include "core/process/process_arguments.h"
#include "core/process/process_impl.h"
#include "core/process/process_signals.h"
#include "core/process/process_usage.h"
#include "core/run/process_names.h"
#include "plslam_version.h"

namespace plslam::bus {

/// One run of a process, from parsed arguments to exit code.
class ProcessRunner {
 public:
  /// `program`: the name of the executable.
  ProcessRunner(const ProcessSpec& spec, const ProcessArguments& arguments, const std::string& program)
      : spec_(spec), arguments_(arguments), program_(program) {}

  int Run() {
    std::optional<Process> process;
    try {
      arguments_.EndWithParent();
      const Config config = arguments_.MakeConfig();
      BusOptions bus_options;
      config.Read(kBusSection, bus_options);
      // Constructed before the bus, whose threads must inherit the blocked signals.
      const SignalWatcher signals([this](const std::string& signal) { OnSignal(signal); }, arguments_.parent);
      process.emplace(spec_.name, bus_options);
      process->impl_->has_launcher = arguments_.parent != 0;
      if (!process->has_launcher()) process->impl_->terminal.Begin(program_);
      if (process->has_launcher()) process->impl_->exit_code_of_namesake = kExitCodeOfNamesake;
      return RunNode(config, *process);
    } catch (const std::exception& error) {
      return Fail(
          IsOfMemory(error) ? fmt::format("{}, while {}", SentenceOf(error), Doing(process)) : SentenceOf(error),
          process);
    } catch (...) {
      return Fail("an exception of unknown type", process);
    }
  }

 private:
  void OnSignal(const std::string& signal) {
    LogInfo("{}: stopping", signal);
    const std::scoped_lock lock(mutex_);
    signalled_ = true;
    if (running_ != nullptr) running_->bus().Stop();
  }

  /// Returns false if a signal arrived before there was a process to stop.
  bool SetRunning(Process* process) {
    const std::scoped_lock lock(mutex_);
    running_ = process;
    return !signalled_;
  }

  int RunNode(const Config& config, Process& process) {
    struct Unset {
      ProcessRunner* runner;
      ~Unset() { runner->SetRunning(nullptr); }
    } unset{this};
    if (!SetRunning(&process)) return 0;
    std::shared_ptr<void> node;
    const auto start = [&] {
      node = spec_.make_node(process, config);
      // A launcher gives all its processes the same options.
      if (!process.has_launcher()) ReportOptionsOfOthers();
      if (process.impl_->status.state() == process_state::kStarting) process.SetState(process_state::kReady);
      ReportReady(process);
    };
    if (arguments_.own_bus) {
      start();
    } else {
      StartUnlessNamesake(process, start);
    }
    process.bus().Run();
    const bool yielded = process.impl_->has_yielded;
    if (!yielded) process.SetState(process_state::kStopping);
    node.reset();
    if (process.impl_->finished) process.bus().Flush(std::chrono::milliseconds(1000));
    if (!yielded) process.impl_->terminal.PrintLine("ended" + ResultsOf(process));
    return process.impl_->exit_code;
  }

  /// Namesakes answer the statuses of a starting process; two answers prove that one runs.
  static void StartUnlessNamesake(Process& process, std::function<void()> start) {
    using std::chrono::milliseconds;
    const auto after = [&process](double s, std::function<void()> task) {
      process.bus().After(milliseconds(std::lround(1e3 * s)), std::move(task));
    };
    for (const double s : {0.0, 0.5 * NamesakeWatch::kStartWindow_s}) {
      after(s, [&process] { process.impl_->status.Publish(); });
    }
    after(NamesakeWatch::kStartWindow_s, std::move(start));
  }

  void ReportOptionsOfOthers() const {
    for (const std::string& assignment : arguments_.overrides) {
      const std::string section = assignment.substr(0, assignment.find('.'));
      if (section == kBusSection || section == spec_.name) continue;
      LogWarning("--set {} has no effect here: {} reads the sections {} and {}", assignment, spec_.name, spec_.name,
                 kBusSection);
    }
  }

  void ReportReady(Process& process) const {
    const BusOptions& options = process.bus().options();
    process.impl_->terminal.PrintLine(
        fmt::format("ready on {}{}", BusText(options.url, options.prefix),
                    spec_.waits_for.empty() ? "" : fmt::format(", waiting for {}", spec_.waits_for)));
  }

  /// ": 400 frames sent, 0 late".
  std::string ResultsOf(Process& process) const {
    std::string text;
    for (const auto& [counter, noun] : spec_.results) {
      text += fmt::format("{}{:.0f} {}", text.empty() ? ": " : ", ", process.impl_->status.counter(counter), noun);
    }
    return text;
  }

  static std::string Doing(const std::optional<Process>& process) {
    return process ? process->impl_->status.state() : "reading the options";
  }

  int Fail(const std::string& what, std::optional<Process>& process) const {
    const std::string line = OneLine(what);
    PrintError(fmt::format("{}: error: {}", spec_.name, line));
    try {
      if (process) process->SetState(process_state::kFailed, line);
    } catch (const std::exception& error) {
      PrintError(fmt::format("{}: error: the failure could not be published: {}", spec_.name, OneLine(error.what())));
    }
    return 1;
  }

  const ProcessSpec& spec_;
  const ProcessArguments& arguments_;
  const std::string program_;
  std::mutex mutex_;
  Process* running_ = nullptr;
  bool signalled_ = false;
};

int RunProcess(int argc, char** argv, const ProcessSpec& spec) {
  CLI::App app(spec.description, argc > 0 ? argv[0] : spec.name);
  app.set_version_flag("--version", PLSLAM_VERSION);
  ProcessArguments arguments;
  arguments.AddTo(&app);
  if (spec.add_options) spec.add_options(&app);
  app.footer(
      (spec.examples.empty() ? "" : fmt::format("Examples:\n{}\n", spec.examples)) +
      "Exit code 0 if done, or ended by SIGINT, SIGTERM or SIGHUP; 1 if not, with one sentence on standard error.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return FlushOutput(spec.name, app.exit(error));
    PrintError(fmt::format("{}: error: {}", spec.name, OneLine(CommandLineError(app, error, argc, argv))));
    return 1;
  }
  SetUpLogging(spec.name);
  signal(SIGPIPE, SIG_IGN);
  IgnoreFileSizeSignal();
  KeepFreedMemory();
  const std::string program = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : spec.name;
  return ProcessRunner(spec, arguments, program).Run();
}

}  // namespace plslam::bus
