// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

namespace plslam::ros2 {

/// The DDS domain that the environment of ROS names.
struct Domain {
  int id = 0;
  bool loopback_only = false;
};

/// Reads ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY and ROS_AUTOMATIC_DISCOVERY_RANGE; `environment` returns nullptr for what is
/// not set. Throws std::runtime_error that names the variable if its value is none that ROS 2 has.
Domain DomainOf(const std::function<const char*(const char* name)>& environment);

/// Returns the configuration of Cyclone DDS for a domain, in which CYCLONEDDS_URI (`user_uri`) has the last word.
std::string CycloneConfiguration(const Domain& domain, const std::string& user_uri);

}  // namespace plslam::ros2
