// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <mutex>
#include <optional>

#include "core/bus/logs/log_writer.h"
#include "core/process/process_arguments.h"
#include "core/process/process_signals.h"
#include "core/process/process_status.h"
#include "tools/plslam/commands.h"

namespace plslam {
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
  status.SetState("ready");
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

}  // namespace plslam
