// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "tools/bridge/foxglove_server.h"

namespace plslam::bridge {

/// Returns whether a page of this origin may connect: Foxglove's own web page, pages of this machine, files of a desktop
/// program, and the one given as `allowed`. A program that is no browser has no origin (empty).
bool IsAllowedOrigin(const std::string& origin, const std::string& allowed);

/// The socket of a FoxgloveServer, by libwebsockets, on a separate thread; 32 clients at a time. A request for anything
/// but the two protocols is answered with status 400 and a sentence, and so is a foreign web page, which could otherwise
/// read the data, and give orders, through the browser of this machine.
class WebSocketServer {
 public:
  struct Place {
    std::string address;
    int port = 0;
    std::string origin;
  };
  /// `Wake` must be called when `server` has output. Throws std::runtime_error if the address or the port is not
  /// available. `server` outlives this object.
  WebSocketServer(FoxgloveServer& server, const Place& place);
  ~WebSocketServer();
  WebSocketServer(const WebSocketServer&) = delete;
  WebSocketServer& operator=(const WebSocketServer&) = delete;

  int port() const;
  /// Safe from any thread.
  void Wake();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam::bridge
