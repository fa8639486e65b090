#include <fmt/format.h>
#include <signal.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <mutex>
#include <optional>

#include "core/bus/process_arguments.h"
#include "core/bus/process_impl.h"
#include "core/bus/process_memory.h"
#include "core/bus/process_signals.h"
#include "core/errors/error_text.h"

namespace plslam::bus {

/// One run of a process, from parsed arguments to exit code.
class ProcessRunner {
 public:
  ProcessRunner(const ProcessSpec& spec, const ProcessArguments& arguments) : spec_(spec), arguments_(arguments) {}

  int Run() {
    std::optional<Process> process;
    try {
      arguments_.EndWithParent();
      const Config config = arguments_.MakeConfig();
      BusOptions bus_options;
      config.Read("bus", bus_options);
      // Before the bus, whose threads must inherit the blocked signals.
      SignalWatcher signals([this](int signal) { OnSignal(signal); });
      process.emplace(spec_.name, bus_options);
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
  void OnSignal(int signal) {
    spdlog::info("{}: stopping", signal == SIGINT ? "SIGINT" : "SIGTERM");
    const std::scoped_lock lock(mutex_);
    signalled_ = true;
    if (running_ != nullptr) running_->bus().Stop();
  }

  /// False where a signal came before there was anything to stop.
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
    std::shared_ptr<void> node = spec_.make_node(process, config);
    if (process.impl_->status.state() == "starting") process.SetState("ready");
    process.bus().Run();
    process.SetState("stopping");
    node.reset();
    if (process.impl_->finished) process.bus().Flush(std::chrono::milliseconds(1000));
    return process.impl_->exit_code;
  }

  static std::string Doing(const std::optional<Process>& process) {
    return process ? process->impl_->status.state() : "reading the options";
  }

  int Fail(const std::string& what, std::optional<Process>& process) const {
    const std::string line = OneLine(what);
    fmt::print(stderr, "{}: error: {}\n", spec_.name, line);
    try {
      if (process) process->SetState("failed", line);
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}: error: the failure could not be told: {}\n", spec_.name, OneLine(error.what()));
    }
    return 1;
  }

  const ProcessSpec& spec_;
  const ProcessArguments& arguments_;
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
  app.footer((spec.examples.empty() ? "" : fmt::format("Examples:\n{}\n", spec.examples)) +
             "Exit code 0 when done, or ended by SIGINT or SIGTERM; 1 when not, and one sentence on standard error "
             "says why.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "{}: error: {} (--help tells the options)\n", spec.name, OneLine(error.what()));
    return 1;
  }
  SetUpLogging(spec.name);
  signal(SIGPIPE, SIG_IGN);
  KeepFreedMemory();
  return ProcessRunner(spec, arguments).Run();
}

}  // namespace plslam::bus
