// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/order_node.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/bus/run_loop.h"
#include "core/bus/transport/transport.h"
#include "plslam/command_answer_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam::launcher {

std::string NoAnswerText(const std::vector<std::string>& processes, const bus::BusOptions& options,
                         std::chrono::seconds waited) {
  return fmt::format(
      "no process '{}' was found on {} with prefix '{}' within {} s; give the --url and --prefix of the running one "
      "(without --url, plslam run uses a private bus), or start one",
      fmt::join(processes, "' or '"), bus::EffectiveUrl(options.url), options.prefix, waited.count());
}

namespace {

/// Whether bus.key_file is set in a process's configuration. Without a key, its messages are read unchecked.
bool HasKey(const std::string& configuration) {
  static const std::string kKey = "\n  key_file: ";
  const size_t at = configuration.find(kKey);
  return at != std::string::npos && configuration.compare(at + kKey.size(), 2, "\"\"") != 0;
}

}  // namespace

OrderNode::OrderNode(bus::Bus& bus, std::vector<std::string> processes, std::string verb)
    : bus_(bus), processes_(std::move(processes)), verb_(std::move(verb)) {
  bus_.Subscribe<command_answer_t>(bus::kCommandAnswer, [this](const command_answer_t& m) { OnAnswer(m); });
  bus_.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
}

void OrderNode::OnStatus(const status_t& message) {
  const bool ours = std::find(processes_.begin(), processes_.end(), message.process) != processes_.end();
  if (!ours) return;
  if (bus_.options().key_file.empty() && HasKey(message.configuration)) needs_key_ = true;
  if (message.pid == pid_) return;
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
  command.target = processes_.size() == 1 ? processes_.front() : "*";
  command.verb = verb_;
  command.argument = *argument_;
  bus_.Publish(bus::kCommand, command);
  ++n_sent_;
}

void OrderNode::OnAnswer(const command_answer_t& message) {
  // Accepts an answer to any of our messages: an order that was answered by a process that has exited since was carried
  // out all the same.
  const bool ours = message.command_source == bus_.source() && message.command_seq < n_sent_;
  if (ours && !answer_) answer_ = message.failure;
}

}  // namespace plslam::launcher
