// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/bus/options.h"
#include "tools/plslam/background_relay.h"
#include "tools/plslam/bus_url.h"
#include "tools/plslam/run_options.h"

namespace plslam {

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

}  // namespace plslam
