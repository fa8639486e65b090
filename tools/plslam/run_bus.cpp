// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_bus.h"

#include <spdlog/spdlog.h>

#include "core/bus/transport/transport.h"
#include "core/config/config.h"

namespace plslam {

RunBus::RunBus(const std::string& url) : url_(url) {
  if (!url_.empty()) return;
  port_ = std::make_unique<PrivatePort>();
  url_ = port_->Url();
  std::string reason;
  if (bus::MulticastWorks(url_, &reason)) return;
  spdlog::warn("no multicast on this machine ({}): messages go through a relay (tcpq)", reason);
  port_.reset();
  relay_ = std::make_unique<BackgroundRelay>();
  url_ = relay_->url();
}

bus::BusOptions RunBus::OptionsFor(const RunOptions& options) const {
  Config config = options.config_file.empty() ? Config() : Config::FromFile(options.config_file);
  for (const std::string& assignment : options.overrides) config.Override(assignment);
  bus::BusOptions result;
  config.Read("bus", result);
  result.url = url_;
  if (!options.prefix.empty()) result.prefix = options.prefix;
  if (!options.map_prefix.empty()) result.map_prefix = options.map_prefix;
  // The loss that is asked for is that of the processes under test.
  result.drop_fraction = 0.0;
  return result;
}

}  // namespace plslam
