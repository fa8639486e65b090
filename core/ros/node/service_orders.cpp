// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/node/service_orders.h"

#include <chrono>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace plslam::bus {

ServiceOrders::ServiceOrders(Bus& bus) : bus_(bus), sender_(bus) {
  bus_.Every(std::chrono::milliseconds(50), [this] { CarryOut(); });
}

void ServiceOrders::Give(ServiceOrder order, Answer answer) {
  bus_.Post([this, call = Call{std::move(order), std::move(answer)}] {
    if (calls_.size() < kMostCalls) {
      calls_.push_back(call);
    } else {
      call.answer(false, fmt::format("{} calls are waiting already", kMostCalls));
    }
  });
}

void ServiceOrders::CarryOut() {
  if (calls_.empty()) return;
  const Call& call = calls_.front();
  if (!std::exchange(is_sent_, true)) sender_.Send(*FindOrder(call.order.verb), call.order.argument);
  const std::optional<OrderResult> result = sender_.Result();
  if (!result) return;
  call.answer(result->done, result->sentence);
  calls_.pop_front();
  is_sent_ = false;
}

}  // namespace plslam::bus
