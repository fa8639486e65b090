// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace plslam::ros2 {

/// Identity of a participant or an endpoint, as DDS sends it.
using Guid = std::array<uint8_t, 16>;

/// A node, as `ros2 node list` and `ros2 node info` show it.
struct NodeInfo {
  Guid participant{};
  std::string space;  ///< "/", or its namespace
  std::string name;
  std::vector<Guid> readers, writers;
};

/// The topic by which nodes introduce themselves, as DDS names it.
inline constexpr const char* kNodeInfoTopic = "ros_discovery_info";

/// Bytes of an identity in messages of ROS: `kGidBytesBeforeIron` in releases up to Humble, whose last eight are 0.
inline constexpr size_t kGidBytes = 16, kGidBytesBeforeIron = 24;

/// Returns rmw_dds_common/msg/ParticipantEntitiesInfo in CDR, in the form of the releases with identities of this size.
std::string NodeInfoMessage(const NodeInfo& info, size_t gid_bytes);

}  // namespace plslam::ros2
