// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <thread>

#include "tools/launch/relay/tcpq_relay.h"

namespace plslam::launcher {

/// A UDP port that no other program on this machine uses; it is reserved until the end of the scope, so that two
/// launchers never pick the same one. Others may share it by number (LCM does), but the kernel assigns it to no program
/// that requests any free port.
class PrivatePort {
 public:
  /// Throws std::runtime_error if there is none.
  PrivatePort();
  ~PrivatePort();
  PrivatePort(const PrivatePort&) = delete;
  PrivatePort& operator=(const PrivatePort&) = delete;

  int port() const { return port_; }
  /// LCM URL on this port, not beyond this machine.
  std::string Url() const;

 private:
  int socket_ = -1;
  int port_ = 0;
};

/// A relay on a free port of this host and on a separate thread, until the end of the scope.
class BackgroundRelay {
 public:
  BackgroundRelay() : relay_(0), thread_([this] { relay_.Run(); }) {}
  ~BackgroundRelay() {
    relay_.Stop();
    thread_.join();
  }
  BackgroundRelay(const BackgroundRelay&) = delete;
  BackgroundRelay& operator=(const BackgroundRelay&) = delete;

  std::string url() const { return relay_.url(); }

 private:
  bus::TcpqRelay relay_;
  std::thread thread_;
};

/// The bus of one run: the given one, or a private one on this host, over multicast if that works and otherwise through
/// our own relay (tcpq).
class RunBus {
 public:
  /// An empty `url` selects a private one. Throws std::runtime_error if neither works.
  explicit RunBus(const std::string& url);

  const std::string& url() const { return url_; }

 private:
  std::unique_ptr<PrivatePort> port_;
  std::unique_ptr<BackgroundRelay> relay_;
  std::string url_;
};

}  // namespace plslam::launcher
