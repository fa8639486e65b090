// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/commands.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/bus/logs/log_writer.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/transport.h"
#include "core/config/config.h"
#include "core/errors/standard_streams.h"
#include "core/process/order_sender.h"
#include "core/process/process_arguments.h"
#include "core/process/process_signals.h"
#include "core/process/process_status.h"
#include "core/run/process_names.h"
#include "tools/launch/relay/tcpq_relay.h"
#include "tools/plslam/all_options.h"
#include "tools/plslam/node/top_node.h"
#include "tools/plslam/process_table.h"

namespace plslam::launcher {
namespace {

/// Prints the options of all processes after the file and the overrides, checked as the processes check them.
int PrintConfiguration(const bus::ProcessArguments& arguments) {
  const Config config = arguments.MakeConfig();
  AllOptions all;
  std::string text;
  for (const OptionSection& section : SectionsOf(all)) {
    config.ReadFields(section.name, section.fields);
    text += fmt::format("{}# {}\n{}", text.empty() ? "" : "\n", section.meaning,
                        FieldsToYaml(section.name, section.fields, true));
  }
  fmt::print("{}", text);
  return 0;
}

}  // namespace

void AddConfigCommand(CLI::App* app, Command* command) {
  auto arguments = std::make_shared<bus::ProcessArguments>();
  auto* sub = app->add_subcommand(
      "config", "prints the configuration that the processes would use, with the meaning of each option");
  sub->add_option("--config", arguments->config_file,
                  "YAML file with options of all processes (docs/configuration.md)")
      ->type_name("FILE");
  sub->add_option("--set", arguments->overrides,
                  "one option, overrides the file: vo.features.orb.max_points=800 (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  sub->footer(
      "Examples:\n"
      "  plslam config > mine.yaml\n"
      "  plslam config --config mine.yaml --set vo.features.orb.max_points=800\n"
      "The output is itself a configuration file.");
  sub->callback([=] { *command = [arguments] { return PrintConfiguration(*arguments); }; });
}

namespace {

int PrintProcesses() {
  fmt::print("{:<10} {:<16} {:<12} {}\n", "name", "executable", "when it ends", "what it does");
  for (const ProcessRow& row : ProcessTable()) {
    fmt::print("{:<10} {:<16} {:<12} {}\n", row.name, row.executable,
               row.ending != Supervisor::Ending::kMayEnd ? "restarted" : "is done", row.meaning);
  }
  return 0;
}

}  // namespace

void AddProcessesCommand(CLI::App* app, Command* command) {
  auto* sub = app->add_subcommand("processes", "prints the table of processes that `run` starts");
  sub->callback([command] { *command = PrintProcesses; });
}

namespace {

constexpr std::chrono::milliseconds kTick(50);

struct OrderOptions {
  bus::ProcessArguments common;
  std::string argument;
  bool force = false;
};

int GiveOrder(const char* verb, const std::string& argument, const bus::ProcessArguments& arguments) {
  bus::BusOptions bus_options;
  arguments.MakeConfig().Read(kBusSection, bus_options);
  bus::Bus bus(bus_options, "plslam");
  bus::OrderSender order(bus);
  order.Send(*bus::FindOrder(verb), argument);
  std::optional<bus::OrderResult> result;
  bool is_waiting = false;
  bus.Every(kTick, [&] {
    result = order.Result();
    const std::string waiting = order.Waiting();
    if (!result && !waiting.empty() && !std::exchange(is_waiting, true)) {
      PrintError(fmt::format("plslam: {}: {}", verb, waiting));
    }
    if (result) bus.Stop();
  });
  bus.Run();
  if (result->done) {
    fmt::print("{}\n", result->sentence);
    return 0;
  }
  PrintError(fmt::format("plslam: error: {}: {}", verb, result->sentence));
  return 1;
}

/// An order about a file on the machine of the process.
void AddFileOrder(CLI::App* app, Command* command, const char* verb, const char* meaning, const char* file) {
  auto options = std::make_shared<OrderOptions>();
  auto* sub = app->add_subcommand(verb, meaning);
  sub->add_option("file", options->argument, file)->required();
  if (std::string_view(verb) == command_verb::kSave) {
    sub->add_flag("--force", options->force, "replace the file even if it is not an older state of this map");
  }
  options->common.AddTo(sub);
  sub->footer(fmt::format("Example:\n  plslam {} out/house.plmap --url udpm://239.255.76.67:7667?ttl=0", verb));
  sub->callback([=] {
    *command = [options, verb] {
      const std::string target = std::filesystem::absolute(options->argument).string();
      return GiveOrder(verb, (options->force ? command_verb::kForce : "") + target, options->common);
    };
  });
}

void AddBareOrder(CLI::App* app, Command* command, const char* verb, const char* meaning) {
  auto options = std::make_shared<OrderOptions>();
  auto* sub = app->add_subcommand(verb, meaning);
  options->common.AddTo(sub);
  sub->footer(fmt::format("Example:\n  plslam {} --url udpm://239.255.76.67:7667?ttl=0", verb));
  sub->callback([=] { *command = [options, verb] { return GiveOrder(verb, "", options->common); }; });
}

}  // namespace

void AddOrderCommands(CLI::App* app, Command* command) {
  AddFileOrder(app, command, command_verb::kSave, "saves the map of the running mapping_process",
               "map file to write, on the machine of mapping_process");
  AddFileOrder(app, command, command_verb::kLoad,
               "loads a saved map into the running mapping_process; trackers start new sessions",
               "map file to read, on the machine of mapping_process");
  AddBareOrder(app, command, command_verb::kReset,
               "starts an empty map in the running mapping_process; trackers start new sessions");
  auto options = std::make_shared<OrderOptions>();
  auto* sub = app->add_subcommand(command_verb::kLocalise, "switches localisation-only mode on or off");
  sub->add_option("on_or_off", options->argument, "on: localise in a fixed map; off: extend the map")
      ->required()
      ->check(CLI::IsMember({localise_mode::kOn, localise_mode::kOff}));
  options->common.AddTo(sub);
  sub->footer("Example:\n  plslam localise on --url udpm://239.255.76.67:7667?ttl=0");
  sub->callback([=] {
    *command = [options] { return GiveOrder(command_verb::kLocalise, options->argument, options->common); };
  });
  AddBareOrder(app, command, command_verb::kPause, "pauses the player or camera");
  AddBareOrder(app, command, command_verb::kResume, "resumes a paused player or camera");
}

namespace {

struct RecordOptions {
  bus::ProcessArguments common;
  std::string file;
  bool force = false;
};

int Record(const RecordOptions& options) {
  bus::SetUpLogging(process_name::kRecorder);
  options.common.EndWithParent();
  bus::BusOptions bus_options;
  options.common.MakeConfig().Read(kBusSection, bus_options);
  std::mutex mutex;
  bus::LogRecorder* running = nullptr;
  bool interrupted = false;
  const auto stop = [&](const std::string&) {
    const std::scoped_lock lock(mutex);
    interrupted = true;
    if (running != nullptr) running->Stop();
  };
  if (!options.force && std::filesystem::exists(options.file)) {
    PrintError(fmt::format("recorder: error: {}: exists already; give another name, or --force to replace it",
                           options.file));
    return 1;
  }
  const bus::SignalWatcher signals(stop, options.common.parent);
  bus::LogRecorder recorder(bus_options, options.file);
  bus::StatusPublisher status(process_name::kRecorder, bus_options, recorder.bus());
  {
    const std::scoped_lock lock(mutex);
    running = &recorder;
    if (interrupted) return 0;
  }
  recorder.OnFailure([&status](const std::string& sentence) {
    status.Warn("recording_stopped", sentence + ": the recording ends here, and all else continues");
  });
  status.SetState(process_state::kReady);
  const auto forget = [&] {
    const std::scoped_lock lock(mutex);
    running = nullptr;
  };
  try {
    recorder.Run();
  } catch (...) {
    forget();
    throw;
  }
  forget();
  fmt::print("{} events in {}\n", recorder.events(), options.file);
  if (!recorder.has_content() && options.common.parent == 0) {
    PrintError(
        fmt::format("recorder: warning: there was no frame, pose or map on {}; give the --url of the running "
                    "processes (without --url, plslam run uses a private bus)",
                    bus::EffectiveUrl(bus_options.url)));
  }
  if (recorder.failure().empty()) {
    status.SetState(process_state::kStopping);
    return 0;
  }
  // Published, too, because the log of this process may be on the same full disk.
  status.SetState(process_state::kFailed, recorder.failure());
  PrintError(fmt::format("recorder: error: {}", recorder.failure()));
  return 1;
}

}  // namespace

void AddRecordCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<RecordOptions>();
  auto* sub = app->add_subcommand("record", "records all traffic in an LCM event log until SIGINT");
  sub->add_option("file", options->file, "log to write, readable by lcm-logplayer and `plslam replay`")->required();
  sub->add_flag("--force", options->force, "replace the file if it exists");
  options->common.AddTo(sub);
  sub->footer("Example:\n  plslam record out/run.lcm --url udpm://239.255.76.67:7667?ttl=0");
  sub->callback([=] { *command = [options] { return Record(*options); }; });
}

namespace {

struct TopOptions {
  bus::ProcessArguments common;
  bool once = false;
  bool json = false;
};

// Time for two statuses of every process, which are published each second.
constexpr std::chrono::milliseconds kListenOnce(2500);
constexpr std::chrono::milliseconds kShowEvery(1000);

int Top(const TopOptions& options) {
  bus::BusOptions bus_options;
  options.common.MakeConfig().Read(kBusSection, bus_options);
  bus::Bus bus(bus_options, "top");
  TopNode node(bus);
  bool heard = false;
  const bool clears = !options.once && !options.json && isatty(STDOUT_FILENO) == 1;
  bus.Every(options.once ? kListenOnce : kShowEvery, [&] {
    const BusLoad load = node.Take(bus::NowS());
    heard |= !load.processes.empty();
    if (options.once && !heard) return bus.Stop();
    if (clears) fmt::print("\x1b[H\x1b[2J");
    fmt::print("{}\n", options.json ? ToJson(load) : ToText(load));
    std::fflush(stdout);
    if (options.once) bus.Stop();
  });
  const bus::SignalWatcher signals([&](const std::string&) { bus.Stop(); });
  bus.Run();
  if (heard || !options.once) return 0;
  PrintError(
      fmt::format("plslam: error: no process was found on {}; give the --url of the running ones (without --url, "
                  "plslam run uses a private bus)",
                  bus::EffectiveUrl(bus_options.url)));
  return 1;
}

}  // namespace

void AddTopCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<TopOptions>();
  auto* sub = app->add_subcommand(
      "top", "prints a table of all processes on the bus, with any prefix, and of its channels once a second");
  sub->add_flag("--once", options->once, "listen for 2.5 s, print one table and exit");
  sub->add_flag("--json", options->json, "print a line of JSON instead of each table");
  options->common.AddTo(sub);
  sub->footer(
      "Examples:\n"
      "  plslam top --url udpm://239.255.76.67:7667?ttl=0\n"
      "  plslam top --once --json");
  sub->callback([=] { *command = [options] { return Top(*options); }; });
}

namespace {

struct RelayOptions {
  int port = 7700;
  std::string address = "127.0.0.1";
};

int Relay(const RelayOptions& options) {
  bus::TcpqRelay* running = nullptr;
  std::mutex mutex;
  const bus::SignalWatcher signals([&](const std::string&) {
    const std::scoped_lock lock(mutex);
    if (running != nullptr) running->Stop();
  });
  bus::TcpqRelay relay(options.port, options.address);
  {
    const std::scoped_lock lock(mutex);
    running = &relay;
  }
  fmt::print("relaying at {}\n", relay.url());
  std::fflush(stdout);
  relay.Run();
  const std::scoped_lock lock(mutex);
  running = nullptr;
  const auto counters = relay.counters();
  fmt::print("{} messages relayed, {} dropped\n", counters.relayed, counters.dropped);
  return 0;
}

}  // namespace

void AddRelayCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<RelayOptions>();
  auto* sub = app->add_subcommand("relay", "relays messages over TCP on hosts without multicast (LCM's tcpq URLs)");
  sub->add_option("--port", options->port, "port to listen on; 0: any free port")
      ->capture_default_str()
      ->check(CLI::Range(0, 65535));
  sub->add_option("--address", options->address, "address to listen on; 0.0.0.0: reachable from other machines")
      ->capture_default_str();
  sub->footer("Example:\n  plslam relay --port 7700 &\n  vo_process --url tcpq://127.0.0.1:7700");
  sub->callback([=] { *command = [options] { return Relay(*options); }; });
}

}  // namespace plslam::launcher
