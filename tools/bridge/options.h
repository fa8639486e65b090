// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam::bridge {

/// Section `bridge` of the configuration.
struct BridgeOptions {
  int port = 8765;
  std::string address = "127.0.0.1";
  std::string origin;
  std::string map_file;
};

template <class Visitor>
void VisitFields(Visitor& visit, BridgeOptions& o) {
  visit("port", o.port, Bounds{0, 65535}, "port of the WebSocket; 0: any free one, which the log names");
  visit("address", o.address, "address to listen on; 0.0.0.0: reachable from other machines");
  visit("origin", o.origin,
        "web page that may connect besides https://app.foxglove.dev and pages of this machine: its origin, "
        "http://robot:8080; empty: none");
  visit("map_file", o.map_file,
        "map file of the services save and load, on the machine of mapping_process; empty: none");
}

}  // namespace plslam::bridge
