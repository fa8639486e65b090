// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/node/order_services.h"

#include <stdexcept>
#include <utility>
#include <vector>

#include "core/errors/log.h"
#include "core/ros/ros_services.h"
#include "ros2/names.h"

namespace plslam::ros2 {
namespace {

std::vector<RosNode::Service> ServicesIn(const std::string& space) {
  std::vector<RosNode::Service> services;
  for (const RosService& row : RosServices())
    services.push_back({InNamespace(space, row.name), std::string(row.type())});
  return services;
}

}  // namespace

OrderServices::OrderServices(bus::Process& process, const Domain& domain, const Ros2Options& options)
    : process_(process),
      map_file_(options.map_file),
      orders_(process.bus()),
      node_(domain,
            OffersOrders(process.bus().options(), domain) ? ServicesIn(options.output_namespace)
                                                          : std::vector<RosNode::Service>(),
            {.on_call = [this](size_t service, std::span<const uint8_t> request,
                               RosNode::Answer answer) { TakeCall(service, request, std::move(answer)); },
             .on_rejected = [this](const std::string& service,
                                   const std::string& reason) { Reject(service, reason); }}) {}

void OrderServices::TakeCall(size_t service, std::span<const uint8_t> request, RosNode::Answer answer) {
  process_.SetCounter("calls", static_cast<double>(++n_calls_));
  try {
    ServiceOrder order = OrderOf(RosServices()[service], request, map_file_, "plslam_ros2");
    LogInfo("called: {} {}", order.verb, order.argument);
    orders_.Give(std::move(order), [answer = std::move(answer)](bool done, const std::string& sentence) {
      LogInfo("answered: {}, {}", done ? "done" : "failed", sentence);
      answer(done, sentence);
    });
  } catch (const std::runtime_error& error) {
    answer(false, error.what());
  }
}

void OrderServices::Reject(const std::string& service, const std::string& reason) {
  process_.SetCounter("calls.rejected", static_cast<double>(++n_rejected_));
  if (n_rejected_ == 1) LogWarning("skipped: a request of {} {}", service, reason);
}

}  // namespace plslam::ros2
