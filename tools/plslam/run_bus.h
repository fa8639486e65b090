// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <thread>

#include "core/bus/options.h"
#include "tools/plslam/relay/tcpq_relay.h"
#include "tools/plslam/run_options.h"

namespace plslam::launcher {

/// A UDP port that nothing else on this machine uses; it stays ours until the end of the scope, so that two launchers
/// never pick the same one. Others may share it (LCM does) but the kernel gives it to nobody who asks for any port.
class PrivatePort {
 public:
  /// Throws std::runtime_error where there is none.
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

/// A relay on a free port of this machine and a thread of its own, until the end of the scope.
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

/// The bus of one run: the one named, or a private one on this machine, over multicast where that works and through a
/// relay of our own (tcpq) where it does not.
class RunBus {
 public:
  /// `url` empty: a private one. Throws std::runtime_error where neither works.
  explicit RunBus(const std::string& url);

  const std::string& url() const { return url_; }
  /// Options of the launcher's own bus, as the other processes will read them.
  bus::BusOptions OptionsFor(const RunOptions& options) const;

 private:
  std::unique_ptr<PrivatePort> port_;
  std::unique_ptr<BackgroundRelay> relay_;
  std::string url_;
};

}  // namespace plslam::launcher
