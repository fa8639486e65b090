#include <fmt/format.h>
#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <optional>

#include "core/bus/process_impl.h"
#include "core/bus/process_signals.h"
#include "core/config/sections.h"

namespace plslam::bus {
namespace {

/// What the command line of every process has.
struct CommonArguments {
  std::string config_file;
  std::vector<std::string> overrides;
  std::optional<std::string> url;
  std::optional<std::string> prefix;
  int parent = 0;
};

void AddCommonOptions(CLI::App* app, CommonArguments* arguments) {
  app->set_version_flag("--version", PLSLAM_VERSION);
  app->add_option("--config", arguments->config_file, "YAML file with the options")->type_name("FILE");
  app->add_option("--set", arguments->overrides, "one option, over the file: vo.orb.max_points=800 (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app->add_option("--url", arguments->url, "LCM URL, for example udpm://239.255.76.67:7667?ttl=0");
  app->add_option("--prefix", arguments->prefix, "in front of each channel name");
  app->add_option("--parent", arguments->parent, "end when the process with this id, which started this one, ends")
      ->type_name("PID");
}

Config MakeConfig(const CommonArguments& arguments) {
  Config config = arguments.config_file.empty() ? Config() : Config::FromFile(arguments.config_file);
  for (const std::string& assignment : arguments.overrides) config.Override(assignment);
  if (arguments.url) config.Override("bus.url=" + *arguments.url);
  if (arguments.prefix) config.Override("bus.prefix=" + *arguments.prefix);
  config.RequireSections(kConfigSections);
  return config;
}

/// Log lines go to stderr, one each; stdout is for results.
void SetUpLogging(const std::string& name) {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>(name, std::make_shared<spdlog::sinks::stderr_color_sink_mt>()));
  spdlog::set_pattern("%H:%M:%S.%e %n %^%l%$: %v");
  spdlog::flush_on(spdlog::level::trace);
}

std::string OneLine(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

/// One run of a process, from parsed arguments to exit code.
class ProcessRunner {
 public:
  ProcessRunner(const ProcessSpec& spec, const CommonArguments& arguments) : spec_(spec), arguments_(arguments) {}

  int Run() {
    std::optional<Process> process;
    try {
      EndWithParent();
      const Config config = MakeConfig(arguments_);
      BusOptions bus_options;
      config.Read("bus", bus_options);
      // Before the bus, whose threads must inherit the blocked signals.
      SignalWatcher signals([this](int signal) { OnSignal(signal); });
      process.emplace(spec_.name, bus_options);
      return RunNode(config, *process);
    } catch (const std::exception& error) {
      return Fail(error.what(), process);
    } catch (...) {
      return Fail("an exception of unknown type", process);
    }
  }

 private:
  void EndWithParent() const {
    if (arguments_.parent == 0) return;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    // It may have ended before the kernel knew of our wish.
    if (getppid() != arguments_.parent) throw std::runtime_error("the process that started this one is gone");
  }

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
    bool has_state;
    {
      const std::scoped_lock lock(process.impl_->mutex);
      has_state = process.impl_->state != "starting";
    }
    if (!has_state) process.SetState("ready");
    process.bus().Run();
    process.SetState("stopping");
    node.reset();
    if (process.impl_->finished) process.bus().Flush(std::chrono::milliseconds(1000));
    return process.impl_->exit_code;
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
  const CommonArguments& arguments_;
  std::mutex mutex_;
  Process* running_ = nullptr;
  bool signalled_ = false;
};

int RunProcess(int argc, char** argv, const ProcessSpec& spec) {
  CLI::App app(spec.description, argc > 0 ? argv[0] : spec.name);
  CommonArguments arguments;
  AddCommonOptions(&app, &arguments);
  if (spec.add_options) spec.add_options(&app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "{}: error: {} (--help tells the options)\n", spec.name, OneLine(error.what()));
    return 1;
  }
  SetUpLogging(spec.name);
  signal(SIGPIPE, SIG_IGN);
  return ProcessRunner(spec, arguments).Run();
}

}  // namespace plslam::bus
