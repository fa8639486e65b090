// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/process/process.h"

namespace plslam {
class command_t;
}  // namespace plslam

namespace plslam::bus {

/// An order of a tool to this process; `verb` as in `command_verb`.
struct Order {
  std::string verb;
  std::string argument;
  /// Who gave it, and the number of the message: the answer names both.
  int64_t source = 0;
  int64_t seq = 0;
};

/// nullopt where it is meant for another process.
std::optional<Order> OrderTo(const Process& process, const command_t& message);

/// Answers the order: it is done, or `failure` says in a sentence why it is not. From any thread.
void Answer(Process& process, const Order& order, const std::string& failure = "");

}  // namespace plslam::bus
