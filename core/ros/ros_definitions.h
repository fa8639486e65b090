// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam {

/// The definition of a message type of ROS 2, "nav_msgs/msg/Path", with all types that it is made of, as schemas of
/// MCAP (encoding ros2msg) have it. Throws std::out_of_range for types that no topic has.
std::string RosDefinition(const std::string& type);

}  // namespace plslam
