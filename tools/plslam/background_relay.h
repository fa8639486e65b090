// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <thread>

#include "tools/plslam/relay/tcpq_relay.h"

namespace plslam {

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

}  // namespace plslam
