// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ros2/domain.h"
#include "ros2/graph/node_info.h"

namespace plslam::ros2 {

/// A node of ROS 2 apart from its topics: its services, for clients of any middleware that is DDS, and its place in
/// `ros2 node list`. By Fast DDS; the one place that includes it: Cyclone DDS, which carries the topics, cannot write the
/// identity of a request beside an answer, by which clients of rmw_fastrtps (the default of ROS) find their own.
class RosNode {
 public:
  struct Service {
    std::string name;  ///< "/plslam/save"
    std::string type;  ///< std_srvs/srv/Trigger or SetBool
  };
  /// Hands over the answer of a call, for `SendAnswers`. Safe from any thread, while the node lives.
  using Answer = std::function<void(bool done, const std::string& sentence)>;
  struct Listener {
    /// A call of a service (its index), with its request in CDR without the bytes of its encoding.
    std::function<void(size_t service, std::span<const uint8_t> request, Answer answer)> on_call;
    /// A message to a service (its name) that is no request, and why.
    std::function<void(const std::string& service, const std::string& reason)> on_rejected;
  };

  /// Both listeners are called on a thread of DDS. Throws std::runtime_error if the domain cannot be joined.
  RosNode(const Domain& domain, const std::vector<Service>& services, Listener listener);
  ~RosNode();
  RosNode(const RosNode&) = delete;
  RosNode& operator=(const RosNode&) = delete;

  /// Sends the answers whose clients can receive them; to be called several times a second.
  void SendAnswers();

  /// Identity of its participant.
  Guid id() const;
  /// Publishes the node with the endpoints of its services and these others, if they have changed. Of one thread.
  void Announce(NodeInfo node, size_t gid_bytes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plslam::ros2
