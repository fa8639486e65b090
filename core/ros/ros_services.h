// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace plslam {

/// A service of ROS for an order of users: a row of the table that the Foxglove socket and DDS offer.
struct RosService {
  std::string_view name;  ///< in the namespace of the node: "save"
  const char* verb;       ///< as in `command_verb`; of a switch: when it is on
  /// The verb when a switch (std_srvs/srv/SetBool) is off; nullptr: the service is no switch (std_srvs/srv/Trigger)
  const char* verb_of_off;
  bool has_file = false;    ///< its argument is the map file
  bool has_on_off = false;  ///< its argument is "on" or "off"

  bool is_switch() const { return verb_of_off != nullptr; }
  std::string_view type() const { return is_switch() ? "std_srvs/srv/SetBool" : "std_srvs/srv/Trigger"; }
};

/// Returns all rows.
std::span<const RosService> RosServices();

/// The order that a call of a service gives.
struct ServiceOrder {
  std::string verb;  ///< as in `command_verb`
  std::string argument;
};

/// Returns the order of a request, in CDR without the four bytes of its encoding. Throws std::runtime_error with the
/// reason if the request is incomplete, or the service needs a map file and `map_file` is empty; `process` is the
/// program of the option --map-file.
ServiceOrder OrderOf(const RosService& service, std::span<const uint8_t> request, const std::string& map_file,
                     std::string_view process);

}  // namespace plslam
