// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <deque>
#include <optional>
#include <string>

#include "core/process/order_sender.h"
#include "core/process/process.h"
#include "core/ros/node/live_run.h"
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
  void GiveOrders();

  bus::Process& process_;
  FoxgloveServer server_;
  bus::LiveRun run_;
  bus::OrderSender orders_;
  std::deque<ServiceCall> calls_;  ///< the first one is being carried out; on the thread of the bus
  bool is_sent_ = false;           ///< its order
  std::atomic<WebSocketServer*> listening_ = nullptr;  ///< `socket_`, whose thread uses it too
  std::optional<WebSocketServer> socket_;
};

bus::ProcessSpec BridgeSpec();

}  // namespace plslam::bridge
