// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/order.h"

#include "core/run/process_names.h"
#include "plslam/command_answer_t.hpp"
#include "plslam/command_t.hpp"

namespace plslam::bus {
namespace {

constexpr size_t kLongestFailure = 2000;

}  // namespace

std::optional<Order> OrderTo(const Process& process, const command_t& message) {
  if (message.target != process.name() && message.target != "*") return std::nullopt;
  return Order{message.verb, message.argument, SourceId(message.header.source), message.header.seq};
}

SaveRequest ToSaveRequest(const std::string& argument) {
  const std::string force = command_verb::kForce;
  const bool forced = argument.starts_with(force);
  return {forced ? argument.substr(force.size()) : argument, forced};
}

void Answer(Process& process, const Order& order, const std::string& failure) {
  command_answer_t message{};
  message.command_source = order.source.value;
  message.command_seq = order.seq;
  message.process = process.name();
  // It may name an argument as long as a message.
  message.failure = failure.substr(0, kLongestFailure);
  process.bus().Publish(kCommandAnswer, message);
}

}  // namespace plslam::bus
