// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/bus/options.h"
#include "core/process/process.h"
#include "core/ros/node/service_orders.h"
#include "ros2/domain.h"
#include "ros2/graph/ros_node.h"
#include "ros2/options.h"

namespace plslam::ros2 {

/// Whether services are offered. With a key on the bus, only holders of it give orders, which DDS cannot prove: then
/// services are for users of this machine alone.
inline bool OffersOrders(const bus::BusOptions& bus, const Domain& domain) {
  return bus.key_file.empty() || domain.loopback_only;
}

/// Orders of users as services of ROS, in the namespace of the node: the rows of `RosServices`, or none if they are not
/// offered.
class OrderServices {
 public:
  /// Throws std::runtime_error if the domain cannot be joined.
  OrderServices(bus::Process& process, const Domain& domain, const Ros2Options& options);

  RosNode& node() { return node_; }

 private:
  void TakeCall(size_t service, std::span<const uint8_t> request, RosNode::Answer answer);
  void Reject(const std::string& service, const std::string& reason);

  bus::Process& process_;
  const std::string map_file_;
  bus::ServiceOrders orders_;
  int64_t n_calls_ = 0, n_rejected_ = 0;  ///< on a thread of DDS
  RosNode node_;                          ///< the last one, since its thread uses the others
};

}  // namespace plslam::ros2
