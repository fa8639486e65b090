#pragma once

#include <memory>
#include <string>

#include "core/bus/options.h"
#include "core/bus/tcpq_relay.h"
#include "tools/plslam/bus_url.h"
#include "tools/plslam/run_options.h"

namespace plslam {

/// The bus of one run: the one named, or a private one on this machine, over multicast where that works and through a
/// relay of our own (tcpq) where it does not.
class RunBus {
 public:
  explicit RunBus(const std::string& url);

  const std::string& url() const { return url_; }
  /// As the other processes of the run will read them from configuration and command line.
  bus::BusOptions OptionsFor(const RunOptions& options) const;

 private:
  std::unique_ptr<PrivatePort> port_;
  std::unique_ptr<bus::TcpqRelay> relay_;
  std::string url_;
};

}  // namespace plslam
