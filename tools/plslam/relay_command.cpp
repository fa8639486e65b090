// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <mutex>

#include "core/process/process_signals.h"
#include "tools/plslam/commands.h"
#include "tools/plslam/relay/tcpq_relay.h"

namespace plslam {
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

}  // namespace plslam
