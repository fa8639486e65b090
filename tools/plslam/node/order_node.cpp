// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/order_node.h"

#include <fmt/format.h>

#include "core/bus/run_loop.h"
#include "core/bus/transport/transport.h"
#include "plslam/command_answer_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam::launcher {

std::string NobodyHeard(const std::string& process, const bus::BusOptions& options, std::chrono::seconds waited) {
  return fmt::format(
      "no process '{}' is heard on {} with prefix '{}' for {} s; give the --url and --prefix of the one that runs "
      "(plslam run takes a bus of its own where it has no --url), or start one",
      process, bus::EffectiveUrl(options.url), options.prefix, waited.count());
}

OrderNode::OrderNode(bus::Bus& bus, std::string process, std::string verb)
    : bus_(bus), process_(std::move(process)), verb_(std::move(verb)) {
  bus_.Subscribe<command_answer_t>(bus::kCommandAnswer, [this](const command_answer_t& m) { OnAnswer(m); });
  bus_.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
}

void OrderNode::OnStatus(const status_t& message) {
  if (message.process != process_ || message.pid == pid_) return;
  pid_ = message.pid;
  if (argument_ && message.uptime_s < bus::NowS() - sent_s_) Publish();
}

void OrderNode::Send(const std::string& argument) {
  if (argument_) return;
  argument_ = argument;
  Publish();
}

void OrderNode::Publish() {
  sent_s_ = bus::NowS();
  command_t command{};
  command.target = process_;
  command.verb = verb_;
  command.argument = *argument_;
  bus_.Publish(bus::kCommand, command);
  ++n_sent_;
}

void OrderNode::OnAnswer(const command_answer_t& message) {
  // Any of ours: one that was answered by a process that has ended since was carried out all the same.
  const bool ours = message.command_source == bus_.source() && message.command_seq < n_sent_;
  if (ours && !answer_) answer_ = message.failure;
}

}  // namespace plslam::launcher
