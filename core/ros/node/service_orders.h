// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <string>

#include "core/process/order_sender.h"
#include "core/ros/ros_services.h"

namespace plslam::bus {

/// Carries out calls of services as orders on the bus, one after the other, and answers each with the answer of the
/// process that carried it out, or the reason why there is none (`OrderSender::Result`).
class ServiceOrders {
 public:
  /// Called on the thread of the bus.
  using Answer = std::function<void(bool done, const std::string& sentence)>;

  explicit ServiceOrders(Bus& bus);

  /// Safe from any thread. A call that finds `kMostCalls` waiting is answered at once: not done.
  void Give(ServiceOrder order, Answer answer);

  static constexpr size_t kMostCalls = 32;

 private:
  struct Call {
    ServiceOrder order;
    Answer answer;
  };
  void CarryOut();

  Bus& bus_;
  OrderSender sender_;
  std::deque<Call> calls_;  ///< the first one is being carried out; on the thread of the bus
  bool is_sent_ = false;    ///< its order
};

}  // namespace plslam::bus
