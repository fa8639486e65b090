// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/commands.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "core/bus/logs/log_writer.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/transport.h"
#include "core/process/process_arguments.h"
#include "core/process/process_signals.h"
#include "core/process/process_status.h"
#include "core/run/process_names.h"
#include "tools/plslam/all_options.h"
#include "tools/plslam/node/save_node.h"
#include "tools/plslam/node/top_node.h"
#include "tools/plslam/process_table.h"
#include "tools/plslam/relay/tcpq_relay.h"

namespace plslam::launcher {
namespace {

/// What the processes would take of the file and the overrides, checked as they check it.
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
  auto* sub =
      app->add_subcommand("config", "prints the configuration that processes would use, with what each option means");
  sub->add_option("--config", arguments->config_file,
                  "YAML file with options of all processes (docs/configuration.md)")
      ->type_name("FILE");
  sub->add_option("--set", arguments->overrides,
                  "one option, over the file: vo.features.orb.max_points=800 (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  sub->footer(
      "Examples:\n"
      "  plslam config > mine.yaml\n"
      "  plslam config --config mine.yaml --set vo.features.orb.max_points=800\n"
      "What it prints is a configuration file itself.");
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
  auto* sub = app->add_subcommand("processes", "the table of processes that `run` starts");
  sub->callback([command] { *command = PrintProcesses; });
}

namespace {

constexpr std::chrono::milliseconds kTick(50);
constexpr std::chrono::seconds kHearLimit(10);
constexpr std::chrono::seconds kSaveLimit(120);

struct SaveOptions {
  bus::ProcessArguments common;
  std::string file;
};

int Save(const SaveOptions& options) {
  bus::BusOptions bus_options;
  options.common.MakeConfig().Read("bus", bus_options);
  bus::Bus bus(bus_options, "plslam");
  SaveNode request(bus);
  const std::string path = std::filesystem::absolute(options.file).string();
  const auto began = std::chrono::steady_clock::now();
  bus.Every(kTick, [&] {
    if (request.heard()) request.Send(path);
    const auto passed = std::chrono::steady_clock::now() - began;
    const bool given_up = passed > (request.heard() ? kSaveLimit : kHearLimit);
    if (given_up || request.result() != SaveNode::Result::kPending) bus.Stop();
  });
  bus.Run();
  if (request.result() == SaveNode::Result::kSaved) {
    fmt::print("the map is in {}\n", path);
    return 0;
  }
  if (request.result() == SaveNode::Result::kFailed) {
    fmt::print(stderr, "plslam: error: {}\n", request.reason());
    return 1;
  }
  fmt::print(stderr, "plslam: error: {}: {}\n", path,
             !request.heard() ? NobodyHeard(bus_options, kHearLimit) : "mapping_process has not answered");
  return 1;
}

}  // namespace

void AddSaveCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<SaveOptions>();
  auto* sub = app->add_subcommand("save", "has the running mapping_process save its map");
  sub->add_option("file", options->file, "map file to write, on the machine of mapping_process")->required();
  options->common.AddTo(sub);
  sub->footer("Example:\n  plslam save out/house.plmap --url udpm://239.255.76.67:7667?ttl=0");
  sub->callback([=] { *command = [options] { return Save(*options); }; });
}

namespace {

struct RecordOptions {
  bus::ProcessArguments common;
  std::string file;
};

int Record(const RecordOptions& options) {
  bus::SetUpLogging("recorder");
  options.common.EndWithParent();
  bus::BusOptions bus_options;
  options.common.MakeConfig().Read("bus", bus_options);
  std::mutex mutex;
  bus::LogRecorder* running = nullptr;
  bool interrupted = false;
  const auto stop = [&](const std::string&) {
    const std::scoped_lock lock(mutex);
    interrupted = true;
    if (running != nullptr) running->Stop();
  };
  const bus::SignalWatcher signals(stop, options.common.parent);
  bus::LogRecorder recorder(bus_options, options.file);
  bus::StatusPublisher status("recorder", bus_options, recorder.bus());
  {
    const std::scoped_lock lock(mutex);
    running = &recorder;
    if (interrupted) return 0;
  }
  status.SetState(process_state::kReady);
  const auto end = [&](const char* state, const std::string& reason) {
    {
      const std::scoped_lock lock(mutex);
      running = nullptr;
    }
    status.SetState(state, reason);
  };
  try {
    recorder.Run();
  } catch (const std::exception& error) {
    // The log of this process may be on the same full disk.
    end("failed", error.what());
    throw;
  }
  end("stopping", "");
  fmt::print("{} events in {}\n", recorder.events(), options.file);
  return 0;
}

}  // namespace

void AddRecordCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<RecordOptions>();
  auto* sub = app->add_subcommand("record", "writes all traffic to an LCM event log, until SIGINT");
  sub->add_option("file", options->file, "log to write, which lcm-logplayer and `plslam replay` read")->required();
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

// Two statuses of every process, which come each second.
constexpr std::chrono::milliseconds kListenOnce(2500);
constexpr std::chrono::milliseconds kShowEvery(1000);

int Top(const TopOptions& options) {
  bus::BusOptions bus_options;
  options.common.MakeConfig().Read("bus", bus_options);
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
  bus::PrintError(
      fmt::format("plslam: error: no process is heard on {}; give the --url of those that run (plslam run "
                  "takes a bus of its own where it has no --url)",
                  bus::EffectiveUrl(bus_options.url)));
  return 1;
}

}  // namespace

void AddTopCommand(CLI::App* app, Command* command) {
  auto options = std::make_shared<TopOptions>();
  auto* sub = app->add_subcommand(
      "top", "a table of all processes on the bus, whatever their prefix, and of its channels, once a second");
  sub->add_flag("--once", options->once, "listens for 2.5 s, prints one table and ends");
  sub->add_flag("--json", options->json, "a line of JSON in place of each table");
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
  auto* sub = app->add_subcommand("relay", "carries messages over TCP where there is no multicast (LCM's tcpq URLs)");
  sub->add_option("--port", options->port, "port to listen at; 0: any free one")
      ->capture_default_str()
      ->check(CLI::Range(0, 65535));
  sub->add_option("--address", options->address, "address to listen at; 0.0.0.0: reachable from other machines")
      ->capture_default_str();
  sub->footer("Example:\n  plslam relay --port 7700 &\n  vo_process --url tcpq://127.0.0.1:7700");
  sub->callback([=] { *command = [options] { return Relay(*options); }; });
}

}  // namespace plslam::launcher
