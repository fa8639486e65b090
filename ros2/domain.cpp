// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/domain.h"

#include <charconv>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "core/errors/error_text.h"

namespace plslam::ros2 {

Domain DomainOf(const std::function<const char*(const char* name)>& environment) {
  constexpr int kLargestId = 232;  // the last one with ports
  const auto value_of = [&](const char* name) {
    const char* const value = environment(name);
    return std::string_view(value == nullptr ? "" : value);
  };
  Domain domain;
  const std::string_view id = value_of("ROS_DOMAIN_ID");
  const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), domain.id);
  const bool is_number = error == std::errc() && end == id.data() + id.size();
  if (!id.empty() && (!is_number || domain.id < 0 || domain.id > kLargestId)) {
    throw std::runtime_error(
        fmt::format("ROS_DOMAIN_ID={} is no number from 0 to {}: set it as for the robot", Shown(id), kLargestId));
  }
  const std::string_view range = value_of("ROS_AUTOMATIC_DISCOVERY_RANGE");
  if (range == "OFF") {
    throw std::runtime_error("ROS_AUTOMATIC_DISCOVERY_RANGE=OFF finds no topics: set it to LOCALHOST or SUBNET");
  }
  domain.loopback_only = value_of("ROS_LOCALHOST_ONLY") == "1" || range == "LOCALHOST";
  return domain;
}

std::string CycloneConfiguration(const Domain& domain, const std::string& user_uri) {
  // Images need more than the default; the kernel grants what net.core.rmem_max allows. At the end each writer waits for
  // readers that have not answered, which may have been killed.
  std::string text =
      "<CycloneDDS><Domain><Internal><SocketReceiveBufferSize min=\"default\" max=\"16MB\"/>"
      "<WriterLingerDuration>100 ms</WriterLingerDuration></Internal>";
  if (domain.loopback_only) {
    text +=
        "<General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces></General><Discovery>"
        "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers>"
        "<Peer address=\"127.0.0.1\"/></Peers></Discovery>";
  }
  text += "</Domain></CycloneDDS>";
  return user_uri.empty() ? text : text + "," + user_uri;
}

}  // namespace plslam::ros2
