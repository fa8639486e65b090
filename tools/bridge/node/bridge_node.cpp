// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bridge/node/bridge_node.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>

#include "core/errors/log.h"
#include "core/run/process_names.h"
#include "plslam/status_t.hpp"

namespace plslam::bridge {
namespace {

void Flatten(const std::string& name, const YAML::Node& node, std::map<std::string, std::string>& values) {
  if (node.IsScalar()) {
    values[name] = node.Scalar();
  } else if (node.IsMap()) {
    for (const auto& entry : node) {
      const auto key = entry.first.as<std::string>();
      Flatten(name.empty() ? key : fmt::format("{}.{}", name, key), entry.second, values);
    }
  }
}

bool IsLoopback(const std::string& address) { return address.starts_with("127.") || address == "localhost"; }

/// With a key on the bus, only holders of it give orders, which the protocol of the socket cannot prove: then they are
/// for users of this machine alone.
bool OffersOrders(const bus::BusOptions& bus, const BridgeOptions& options) {
  return bus.key_file.empty() || IsLoopback(options.address);
}

}  // namespace

BridgeNode::BridgeNode(bus::Process& process, const BridgeOptions& options)
    : process_(process),
      server_(std::to_string(process.bus().source().value), OffersOrders(process.bus().options(), options),
              options.map_file,
              {.on_output =
                   [this] {
                     if (WebSocketServer* const socket = listening_) socket->Wake();
                   },
               .on_call =
                   [this](ServiceCall call) {
                     orders_.Give(call.order, [this, call](bool done, const std::string& sentence) {
                       server_.Answer(call, done, sentence);
                     });
                   }}),
      run_(process.bus(), LiveMessages([this](const RosTopic& topic, int64_t t_ns, std::string cdr) {
             server_.Write(topic, t_ns, std::move(cdr));
           }),
           [this] { return server_.wants_images(); }),
      orders_(process.bus()) {
  BridgeOptions shown = options;
  process_.SetConfiguration(ToYaml("bridge", shown));
  process_.bus().Subscribe<status_t>(bus::kStatus, [this](const status_t& message) { OnStatus(message); });
  process_.bus().Every(std::chrono::milliseconds(1000), [this] {
    process_.SetCounter("clients", static_cast<double>(server_.n_clients()));
    process_.SetCounter("messages.skipped", static_cast<double>(server_.n_dropped()));
  });
  socket_.emplace(server_, WebSocketServer::Place{options.address, options.port, options.origin});
  listening_ = &*socket_;
  LogInfo("connect Foxglove or Lichtblick to ws://{}:{}", options.address, socket_->port());
}

void BridgeNode::OnStatus(const status_t& message) {
  std::map<std::string, std::string> values;
  try {
    Flatten("", YAML::Load(message.configuration), values);
  } catch (const YAML::Exception&) {
    return;  // a configuration that did not fit into its message
  }
  // All processes have the section of the bus.
  std::erase_if(values, [&](const auto& value) { return value.first.starts_with("bus."); });
  server_.SetParameters(message.process, std::move(values));
}

bus::ProcessSpec BridgeSpec() {
  struct CommandLine {
    std::optional<int> port;
    std::optional<std::string> address, origin, map_file;
  };
  const auto line = std::make_shared<CommandLine>();
  bus::ProcessSpec spec;
  spec.name = process_name::kBridge;
  spec.description = "Serves a running system live to Foxglove and Lichtblick, through a WebSocket.";
  spec.examples =
      "  plslam bridge --url udpm://239.255.76.67:7667?ttl=0\n"
      "  plslam bridge --url udpm://239.255.76.67:7667?ttl=0 --address 0.0.0.0 --map-file house.plmap";
  spec.add_options = [line](CLI::App* app) {
    app->add_option("--port", line->port, "port of the WebSocket (8765); 0: any free one")
        ->check(CLI::Range(0, 65535));
    app->add_option("--address", line->address, "address to listen on (127.0.0.1); 0.0.0.0: all");
    app->add_option("--origin", line->origin, "web page that may connect besides Foxglove's own: http://robot:8080");
    app->add_option("--map-file", line->map_file, "map file of the services save and load");
  };
  spec.make_node = [line](bus::Process& process, const Config& config) {
    BridgeOptions options;
    config.Read("bridge", options);
    if (line->port) options.port = *line->port;
    if (line->address) options.address = *line->address;
    if (line->origin) options.origin = *line->origin;
    if (line->map_file) options.map_file = *line->map_file;
    if (!options.map_file.empty()) options.map_file = std::filesystem::absolute(options.map_file).string();
    return std::make_shared<BridgeNode>(process, options);
  };
  spec.waits_for = "messages";
  return spec;
}

}  // namespace plslam::bridge
