// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/ids/ids.h"
#include "core/process/process.h"

namespace plslam {
class command_t;
}  // namespace plslam

namespace plslam::bus {

/// An order of a tool to this process; `verb` as in `command_verb`.
struct Order {
  std::string verb;
  std::string argument;
  /// Source and number of the command's message, which the answer repeats.
  SourceId source{};
  int64_t seq = 0;
};

/// Returns the order in a command; nullopt if it is for another process.
std::optional<Order> OrderTo(const Process& process, const command_t& message);

/// The argument of "save".
struct SaveRequest {
  std::string file;
  bool forced = false;  ///< whether a file that is not an older state of this map is replaced
};
SaveRequest ToSaveRequest(const std::string& argument);

/// Answers the order: success, or the reason of its `failure` in a sentence. Safe from any thread.
void Answer(Process& process, const Order& order, const std::string& failure = "");

}  // namespace plslam::bus
