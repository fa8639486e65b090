// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "core/process/process.h"
#include "core/ros/node/live_run.h"
#include "core/ros/node/service_orders.h"
#include "tools/bridge/options.h"
#include "tools/bridge/web_socket_server.h"

namespace plslam::bridge {

/// Serves the run on the bus to Foxglove and Lichtblick: `bus::LiveRun` in, a WebSocket out; calls of services become
/// orders, one after the other.
class BridgeNode {
 public:
  /// Throws std::runtime_error if the port is not available.
  BridgeNode(bus::Process& process, const BridgeOptions& options);

 private:
  void OnStatus(const status_t& message);

  bus::Process& process_;
  FoxgloveServer server_;
  bus::LiveRun run_;
  bus::ServiceOrders orders_;
  std::atomic<WebSocketServer*> listening_ = nullptr;  ///< `socket_`, whose thread uses it too
  std::optional<WebSocketServer> socket_;
};

bus::ProcessSpec BridgeSpec();

}  // namespace plslam::bridge
